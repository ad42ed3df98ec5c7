#version 460
#extension GL_GOOGLE_include_directive : require
// EV100 from the histogram (exposure_meter.h), or the value that is asked for; slowly in sequences (docs/exposure.md).
#include "render/render_shared.h"
layout(local_size_x = 256) in;
layout(set = 0, binding = 0, scalar) readonly buffer HistogramBlock { uint bins[]; } histogram;
layout(set = 0, binding = 1, scalar) writeonly buffer StateBlock { ExposureState state; } exposure;
layout(set = 0, binding = 2, scalar) buffer AdaptedBlock { ExposureState state; } adapted;  // of the frame before
layout(push_constant, scalar) uniform PushBlock { ExposurePush push; };
shared float meter_bins[kHistogramBins];
#include "render/exposure_meter.h"

void main() {
  meter_bins[gl_LocalInvocationIndex] = float(histogram.bins[gl_LocalInvocationIndex]);
  barrier();
  if (gl_LocalInvocationIndex != 0u) return;
  float ev100 = push.fixed_ev100;
  if (push.automatic != 0u) {
    // Zero before the first frame, which has nothing to come from.
    float keep = adapted.state.exposure > 0.0 ? push.keep_share : 0.0;
    ev100 = mix(metered_ev100(push.min_ev100, push.max_ev100, push.compensation_ev), adapted.state.ev100, keep);
  }
  ExposureState state = ExposureState(ev100, exposure_from_ev100(ev100));
  exposure.state = state;
  adapted.state = state;
}
