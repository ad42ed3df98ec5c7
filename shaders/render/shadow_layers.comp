#version 460
#extension GL_GOOGLE_include_directive : require
// For the layers of an EXR: the share of the key light that clouds let through to the surface, and to what the pixel shows
// most of: the surface, or the clouds at their mean depth. 1 where there is neither.
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, scalar) uniform FrameBlock { FrameConstants frame_data; } frame;
#include "clouds/shadow_map.glsl"
layout(set = 0, binding = 20) uniform sampler2D depth_m;
layout(set = 0, binding = 21) uniform sampler2D sun_visible_share;  // of surfaces
layout(set = 0, binding = 22) uniform sampler2D cloud_radiance;
layout(set = 0, binding = 23) uniform sampler2D cloud_info;
layout(set = 0, binding = 24, rg32f) uniform writeonly image2D shadow_layers;

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, ivec2(frame.frame_data.size)))) return;
  bool surface = texelFetch(depth_m, pixel, 0).r < 0.5 * kFarDepth_m;
  float shadow = surface ? texelFetch(sun_visible_share, pixel, 0).r : 1.0;
  float cloud_m = texelFetch(cloud_info, pixel, 0).r;
  bool cloud = cloud_m < 0.5 * kFarDepth_m && texelFetch(cloud_radiance, pixel, 0).a < 0.5;
  float at_cloud = cloud_sun_transmittance(pixel_direction(frame.frame_data, vec2(pixel) + 0.5) * (cloud ? cloud_m : 0.0));
  imageStore(shadow_layers, pixel, vec4(shadow, cloud ? at_cloud : shadow, 0.0, 0.0));
}
