#version 460
#extension GL_GOOGLE_include_directive : require
// Puts the change that shade and haze make, read from the frustum grid, on the background and on the clouds.
#include "common/frame.h"
#include "common/gamut.h"
#include "render/shaft_shared.h"
layout(local_size_x = 16, local_size_y = 16) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1) uniform sampler2D depth_m;
layout(set = 0, binding = 2) uniform sampler2D cloud_depths;  // the nearer and the farther one, m
layout(set = 0, binding = 3) uniform sampler3D froxel_change;
layout(set = 0, binding = 7) uniform sampler2D background;
layout(set = 0, binding = 8) uniform sampler2D cloud_radiance;
layout(set = 0, binding = 11) uniform sampler2D cloud_near;  // what cloud_radiance has at the nearer depth; its opacity
layout(set = 0, binding = 9, rgba32f) uniform writeonly image2D out_background;
layout(set = 0, binding = 10, rgba32f) uniform writeonly image2D out_cloud;
layout(constant_id = 8) const uint PART = 0u;  // 0: background and clouds, 1: the background, 2: clouds at listed pixels
#define PIXEL_LIST_BINDING 13
#define PIXEL_LIST_CONSTANT 9
#include "clouds/pixel_list.glsl"
layout(push_constant, scalar) uniform PushBlock { FroxelGrid grid; uint has_clouds; } push;

vec4 change_to(vec2 uv, float distance_m) {
  float x = froxel_slice(push.grid, distance_m), first = min(x, 1.0);
  vec4 change = textureLod(froxel_change, vec3(uv, (x - 0.5) / float(push.grid.size.z)), 0.0);
  return mix(vec4(0.0, 0.0, 0.0, 1.0), change, first);
}

void main() {
  FrameConstants f = frame.frame_data;
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (LISTED) {
    if (!listed_pixel(gl_WorkGroupID.x * 256u + gl_LocalInvocationIndex, pixel)) return;
  } else if (any(greaterThanEqual(pixel, ivec2(f.size)))) {
    return;
  }
  vec2 uv = (vec2(pixel) + 0.5) / vec2(f.size);
  if (PART != 2u) {
    vec4 behind = change_to(uv, min(texelFetch(depth_m, pixel, 0).r, kFarDepth_m));
    vec3 seen = texelFetch(background, pixel, 0).rgb;
    imageStore(out_background, pixel, vec4(max(within_rec709(seen * behind.a + behind.rgb), vec3(0.0)), 1.0));
  }
  if (push.has_clouds != 0u && PART != 1u) {
    vec4 premultiplied = texelFetch(cloud_radiance, pixel, 0), near = texelFetch(cloud_near, pixel, 0);
    vec2 depths = texelFetch(cloud_depths, pixel, 0).rg;
    vec4 before = change_to(uv, depths.x), beyond = change_to(uv, depths.y);
    vec3 light = near.rgb * before.a + before.rgb * near.a + (premultiplied.rgb - near.rgb) * beyond.a + beyond.rgb * (1.0 - premultiplied.a - near.a);
    imageStore(out_cloud, pixel, vec4(max(within_rec709(light), vec3(0.0)), premultiplied.a));
  }
}
