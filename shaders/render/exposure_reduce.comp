#version 460
#extension GL_GOOGLE_include_directive : require
// EV100 from the histogram: the log-average of the middle of it (10th to 98th percentile), or the value that is asked for.
#include "common/tonemap.h"
#include "render/render_shared.h"
layout(local_size_x = 1) in;
layout(set = 0, binding = 0, scalar) buffer HistogramBlock { uint bins[]; } histogram;
layout(set = 0, binding = 1, scalar) buffer StateBlock { ExposureState state; } exposure;
layout(push_constant, scalar) uniform PushBlock { ExposurePush push; };
void main() {
  float ev100 = push.fixed_ev100;
  if (push.automatic != 0u) {
    float total = 0.0;
    for (uint i = 0u; i < kHistogramBins; ++i) total += float(histogram.bins[i]);
    float low = 0.10 * total, high = 0.98 * total;
    float seen = 0.0, weight = 0.0, sum = 0.0;
    for (uint i = 0u; i < kHistogramBins; ++i) {
      float n = float(histogram.bins[i]);
      float inside = max(min(seen + n, high) - max(seen, low), 0.0);
      float centre = kHistogramMinLog2 + (float(i) + 0.5) / float(kHistogramBins) * (kHistogramMaxLog2 - kHistogramMinLog2);
      sum += inside * centre;
      weight += inside;
      seen += n;
    }
    float average = weight > 0.0 ? exp2(sum / weight) : 1.0;
    ev100 = clamp(ev100_from_luminance(average), push.min_ev100, push.max_ev100);
  }
  exposure.state.ev100 = ev100;
  exposure.state.exposure = exposure_from_ev100(ev100);
}
