#version 460
#extension GL_GOOGLE_include_directive : require
// EV100 from the histogram, or the value that is asked for. Half way (in stops) between two meters: one that makes the
// log-average (10th to 98th percentile) middle grey, 0.18; and one that puts the 99th percentile at 0.9 of saturation. The
// first alone turns a sea of clouds grey, the second a forest black. Then darker by night, and slowly (docs/exposure.md).
#include "common/tonemap.h"
#include "render/render_shared.h"
layout(local_size_x = 256) in;
layout(set = 0, binding = 0, scalar) readonly buffer HistogramBlock { uint bins[]; } histogram;
layout(set = 0, binding = 1, scalar) writeonly buffer StateBlock { ExposureState state; } exposure;
layout(set = 0, binding = 2, scalar) buffer AdaptedBlock { ExposureState state; } adapted;  // of the frame before
layout(push_constant, scalar) uniform PushBlock { ExposurePush push; };
shared float local_bins[kHistogramBins];

const float kBinLog2 = (kHistogramMaxLog2 - kHistogramMinLog2) / float(kHistogramBins);

// Counted values from bin `first` on, and the log2 luminance that only `share` of them exceed.
float count_from(uint first, float share, out float bright_log2) {
  float total = 0.0;
  for (uint i = first; i < kHistogramBins; ++i) total += local_bins[i];
  float above = 0.0;
  bright_log2 = kHistogramMinLog2;
  for (uint i = kHistogramBins; i > first; --i) {
    float n = local_bins[i - 1u];
    if (above < share * total) bright_log2 = kHistogramMinLog2 + kBinLog2 * (float(i) - min((share * total - above) / max(n, 1.0), 1.0));
    above += n;
  }
  return total;
}

float metered_ev100() {
  float bright_log2;
  if (count_from(0u, 0.01, bright_log2) == 0.0) return push.min_ev100;
  // A millionth of the brightest is black too: space with its stars beside the sunlit Earth.
  uint first = uint(max((bright_log2 - 20.0 - kHistogramMinLog2) / kBinLog2, 0.0));
  float large_log2;
  float total = count_from(first, 0.1, large_log2);
  count_from(first, 0.01, bright_log2);
  float low = 0.10 * total, high = 0.98 * total;
  float seen = 0.0, sum = 0.0;
  for (uint i = first; i < kHistogramBins; ++i) {
    float n = local_bins[i];
    float inside = max(min(seen + n, high) - max(seen, low), 0.0);
    sum += inside * (kHistogramMinLog2 + (float(i) + 0.5) * kBinLog2);
    seen += n;
  }
  float grey_ev100 = ev100_that_shows(exp2(sum / (high - low)), 0.18);
  float bright_ev100 = ev100_that_shows(exp2(bright_log2), 0.9);
  // Where all is bright (clouds from above, snow) the second alone counts: white stays white.
  float ev100 = min(0.5 * (grey_ev100 + bright_ev100), bright_ev100);
  // A tenth of the picture is a subject: the moon in a long lens is not lost in white for the black around it.
  ev100 = max(ev100, ev100_that_shows(exp2(large_log2), 0.9) - 1.2);
  float metered = 0.18 / exposure_from_ev100(ev100);  // the luminance that would be middle grey
  return clamp(ev100 + night_darkening_ev(metered) - push.compensation_ev, push.min_ev100, push.max_ev100);
}

void main() {
  local_bins[gl_LocalInvocationIndex] = float(histogram.bins[gl_LocalInvocationIndex]);
  barrier();
  if (gl_LocalInvocationIndex != 0u) return;
  float ev100 = push.fixed_ev100;
  if (push.automatic != 0u) {
    // Zero before the first frame, which has nothing to come from.
    float keep = adapted.state.exposure > 0.0 ? push.keep_share : 0.0;
    ev100 = mix(metered_ev100(), adapted.state.ev100, keep);
  }
  ExposureState state = ExposureState(ev100, exposure_from_ev100(ev100));
  exposure.state = state;
  adapted.state = state;
}
