#version 460
#extension GL_GOOGLE_include_directive : require
// Stands for the march in tests: copies what a made-up scene has at the listed pixels.
#include "common/shared.h"
layout(local_size_x = 16, local_size_y = 16) in;
#define PIXEL_LIST_BINDING 0
#define PIXEL_LIST_CONSTANT 0
#include "clouds/pixel_list.glsl"
layout(set = 0, binding = 2) uniform sampler2D cloud;
layout(set = 0, binding = 3) uniform sampler2D info;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2D out_cloud;
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2D out_info;
void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (LISTED) {
    if (!listed_pixel(gl_WorkGroupID.x * 256u + gl_LocalInvocationIndex, pixel)) return;
  } else if (any(greaterThanEqual(pixel, textureSize(cloud, 0)))) {
    return;
  }
  imageStore(out_cloud, pixel, texelFetch(cloud, pixel, 0));
  imageStore(out_info, pixel, texelFetch(info, pixel, 0));
}
