#version 460
#extension GL_GOOGLE_include_directive : require
// EV100 from the histogram, or the value that is asked for. Half way (in stops) between two meters: one that makes the
// log-average (10th to 98th percentile) middle grey, 0.18; and one that puts the 99th percentile at 0.9 of saturation. The
// first alone turns a sea of clouds grey, the second a forest black.
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
    float low = 0.10 * total, high = 0.98 * total, bright = 0.99 * total;
    float seen = 0.0, weight = 0.0, sum = 0.0, bright_log2 = 0.0;
    for (uint i = 0u; i < kHistogramBins; ++i) {
      float n = float(histogram.bins[i]);
      float inside = max(min(seen + n, high) - max(seen, low), 0.0);
      float centre = kHistogramMinLog2 + (float(i) + 0.5) / float(kHistogramBins) * (kHistogramMaxLog2 - kHistogramMinLog2);
      sum += inside * centre;
      weight += inside;
      if (seen <= bright && n > 0.0) bright_log2 = centre;
      seen += n;
    }
    float average = weight > 0.0 ? exp2(sum / weight) : 1.0;
    float grey_ev100 = log2(average / (0.18 * 1.2));
    float bright_ev100 = bright_log2 - log2(0.9 * 1.2);
    ev100 = clamp(0.5 * (grey_ev100 + bright_ev100), push.min_ev100, push.max_ev100);
  }
  exposure.state.ev100 = ev100;
  exposure.state.exposure = exposure_from_ev100(ev100);
}
