#version 460
#extension GL_GOOGLE_include_directive : require
// Clouds over what lies behind them: both already carry their own air.
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D background;
layout(set = 0, binding = 1) uniform sampler2D cloud_radiance;  // rgb premultiplied, a transmittance
layout(set = 0, binding = 2, rgba32f) uniform writeonly image2D radiance;
void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, imageSize(radiance)))) return;
  vec4 cloud = texelFetch(cloud_radiance, pixel, 0);
  imageStore(radiance, pixel, vec4(texelFetch(background, pixel, 0).rgb * cloud.a + cloud.rgb, 1.0));
}
