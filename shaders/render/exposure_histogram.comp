#version 460
#extension GL_GOOGLE_include_directive : require
// Histogram of log2 luminance, of every stride-th pixel in both directions. Integer counts: the order of the adds does not
// matter, so equal pictures count alike.
#include "common/tonemap.h"
#include "render/render_shared.h"
layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2D radiance;
layout(set = 0, binding = 1, scalar) buffer HistogramBlock { uint bins[]; } histogram;
layout(push_constant, scalar) uniform PushBlock { ExposurePush push; };
shared uint local_bins[kHistogramBins];
void main() {
  local_bins[gl_LocalInvocationIndex] = 0u;
  barrier();
  uvec2 pixel = gl_GlobalInvocationID.xy * push.stride + push.stride / 2u;
  if (all(lessThan(pixel, push.size))) {
    float l = luminance(texelFetch(radiance, ivec2(pixel), 0).rgb);
    if (meter_counts(l)) atomicAdd(local_bins[meter_bin(l)], 1u);
  }
  barrier();
  uint count = local_bins[gl_LocalInvocationIndex];
  if (count > 0u) atomicAdd(histogram.bins[gl_LocalInvocationIndex], count);
}
