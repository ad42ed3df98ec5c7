// Automatic exposure: EV100 from a histogram of luminances (docs/exposure.md). In C++ the histogram is an argument; a
// shader declares `shared float meter_bins[kHistogramBins]` before it includes this.
#ifndef NEPHO_RENDER_EXPOSURE_METER_H
#define NEPHO_RENDER_EXPOSURE_METER_H
#include "common/tonemap.h"
#include "render/render_shared.h"
#ifdef __cplusplus
#define METER_BINS const float *meter_bins,
#define METER_PASS meter_bins,
#else
#define METER_BINS
#define METER_PASS
#endif
SHARED_BEGIN

SHARED_CONST float kMeterBinLog2 = (kHistogramMaxLog2 - kHistogramMinLog2) / float(kHistogramBins);

// Counted values from bin `first` on, and the log2 luminance that only `share` of them exceed.
SHARED_FN float meter_count_from(METER_BINS uint first, float share, SHARED_OUT(float) bright_log2) {
  float total = 0.0f;
  for (uint i = first; i < kHistogramBins; ++i) total += meter_bins[i];
  float above = 0.0f;
  bright_log2 = kHistogramMinLog2;
  for (uint i = kHistogramBins; i > first; --i) {
    float n = meter_bins[i - 1u];
    if (above < share * total)
      bright_log2 = kHistogramMinLog2 + kMeterBinLog2 * (float(i) - min((share * total - above) / max(n, 1.0f), 1.0f));
    above += n;
  }
  return total;
}

// Half way (in stops) between two meters: one that makes the log-average (10th to 98th percentile) middle grey, 0.18; and
// one that puts the 99th percentile at 0.9 of saturation. The first alone turns a sea of clouds grey, the second a forest
// black. Then darker by night, brighter by `compensation_ev`, and within the limits. `min_ev100` where nothing counts.
SHARED_FN float metered_ev100(METER_BINS float min_ev100, float max_ev100, float compensation_ev) {
  float bright_log2;
  if (meter_count_from(METER_PASS 0u, 0.01f, bright_log2) == 0.0f) return min_ev100;
  // A millionth of the brightest is black too: space with its stars beside the sunlit Earth.
  uint first = uint(max((bright_log2 - 20.0f - kHistogramMinLog2) / kMeterBinLog2, 0.0f));
  float large_log2;
  float total = meter_count_from(METER_PASS first, 0.1f, large_log2);
  meter_count_from(METER_PASS first, 0.01f, bright_log2);
  float low = 0.10f * total, high = 0.98f * total;
  float seen = 0.0f, sum = 0.0f;
  for (uint i = first; i < kHistogramBins; ++i) {
    float n = meter_bins[i];
    float inside = max(min(seen + n, high) - max(seen, low), 0.0f);
    sum += inside * (kHistogramMinLog2 + (float(i) + 0.5f) * kMeterBinLog2);
    seen += n;
  }
  float grey_ev100 = ev100_that_shows(exp2(sum / (high - low)), 0.18f);
  float bright_ev100 = ev100_that_shows(exp2(bright_log2), 0.9f);
  // Where all is bright (clouds from above, snow) the second alone counts: white stays white.
  float ev100 = min(0.5f * (grey_ev100 + bright_ev100), bright_ev100);
  // A tenth of the picture is a subject: the moon in a long lens is not lost in white for the black around it.
  ev100 = max(ev100, ev100_that_shows(exp2(large_log2), 0.9f) - 1.2f);
  float metered = 0.18f / exposure_from_ev100(ev100);  // the luminance that would be middle grey
  return clamp(ev100 + night_darkening_ev(metered) - compensation_ev, min_ev100, max_ev100);
}

SHARED_END
#endif
