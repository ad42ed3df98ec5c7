#version 460
#extension GL_GOOGLE_include_directive : require
// Puts the change that shade and haze make, known for blocks of pixels, on the background and on the clouds.
#include "common/frame.h"
#include "common/gamut.h"
#include "render/shaft_shared.h"
layout(local_size_x = 16, local_size_y = 16) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1) uniform sampler2D depth_m;
layout(set = 0, binding = 2) uniform sampler2D cloud_depths;  // the nearer and the farther one, m
layout(set = 0, binding = 3) uniform sampler2D near_tex;
layout(set = 0, binding = 4) uniform sampler2D far_tex;
layout(set = 0, binding = 5) uniform sampler2D cloud_near_tex;
layout(set = 0, binding = 6) uniform sampler2D cloud_far_tex;
layout(set = 0, binding = 11) uniform sampler2D depths_tex;
layout(set = 0, binding = 7) uniform sampler2D background;
layout(set = 0, binding = 8) uniform sampler2D cloud_radiance;
layout(set = 0, binding = 12) uniform sampler2D cloud_near;  // what cloud_radiance has at the nearer depth; its opacity
layout(set = 0, binding = 9, rgba32f) uniform writeonly image2D out_background;
layout(set = 0, binding = 10, rgba32f) uniform writeonly image2D out_cloud;
layout(constant_id = 8) const uint PART = 0u;  // 0: background and clouds, 1: the background, 2: clouds at listed pixels
#define PIXEL_LIST_BINDING 13
#define PIXEL_LIST_CONSTANT 9
#include "clouds/pixel_list.glsl"
layout(push_constant, scalar) uniform PushBlock { ShaftApplyPush push; };

// What a block says of a distance: between its nearest and its farthest one, where there is one between; else in proportion, and with less
// weight.
vec4 change_at(vec4 nearest, vec4 farthest, vec2 depths, float distance_m, float entry_m, out float weight) {
  float at = shaft_share(distance_m, entry_m), from = shaft_share(depths.x, entry_m), to = shaft_share(depths.y, entry_m);
  vec4 change = mix(nearest, farthest, clamp((at - from) / max(to - from, 1.0e-6), 0.0, 1.0));
  float off = shaft_depth(distance_m) - shaft_depth(clamp(distance_m, depths.x, depths.y));
  weight = 1.0 / (1.0 + 1.0e4 * off * off);
  change.rgb *= clamp(at / max(clamp(at, from, to), 1.0e-6), 0.5, 2.0);
  return change;
}

void main() {
  FrameConstants f = frame.frame_data;
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (LISTED) {
    if (!listed_pixel(gl_WorkGroupID.x * 256u + gl_LocalInvocationIndex, pixel)) return;
  } else if (any(greaterThanEqual(pixel, ivec2(f.size)))) {
    return;
  }
  float distance_m = min(texelFetch(depth_m, pixel, 0).r, kFarDepth_m);
  vec2 cloud_m = texelFetch(cloud_depths, pixel, 0).rg;
  vec2 shell;
  float entry_m = intersect_shell(f.planet, pixel_direction(f, vec2(pixel) + 0.5), push.top_m, shell) ? max(shell.x, 0.0) : 0.0;
  vec2 place = (vec2(pixel) + 0.5) / vec2(push.block) - 0.5;
  // At the rim of the picture the line through the last two blocks goes on: a pixel's own block knows its distance, so that no sum of weights is
  // near zero.
  ivec2 last = textureSize(depths_tex, 0) - 1, low = clamp(ivec2(floor(place)), ivec2(0), max(last - 1, ivec2(0)));
  vec2 part = place - vec2(low);
  vec4 behind = vec4(0.0), cloud[2] = vec4[2](vec4(0.0), vec4(0.0));
  float behind_weight = 0.0, cloud_weight[2] = float[2](0.0, 0.0);
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = ivec2(i & 1, i >> 1);
    ivec2 at = clamp(low + corner, ivec2(0), last);
    vec2 w = mix(1.0 - part, part, vec2(corner));
    float share = w.x * w.y, weight;
    vec4 depths = texelFetch(depths_tex, at, 0);
    vec4 change;
    if (PART != 2u) {
      change = change_at(texelFetch(near_tex, at, 0), texelFetch(far_tex, at, 0), depths.xy, distance_m, entry_m, weight);
      behind += share * weight * change;
      behind_weight += share * weight;
    }
    for (int k = 0; k < 2 && PART != 1u; ++k) {
      change = change_at(texelFetch(cloud_near_tex, at, 0), texelFetch(cloud_far_tex, at, 0), depths.zw, cloud_m[k], entry_m, weight);
      if (depths.w <= 0.0) weight = 0.0;
      cloud[k] += share * weight * change;
      cloud_weight[k] += share * weight;
    }
  }
  if (PART != 2u) {
    behind /= behind_weight;
    vec3 seen = texelFetch(background, pixel, 0).rgb;
    imageStore(out_background, pixel, vec4(max(within_rec709(seen * behind.a + behind.rgb), vec3(0.0)), 1.0));
  }
  if (push.has_clouds != 0u && PART != 1u) {
    for (int k = 0; k < 2; ++k) cloud[k] = cloud_weight[k] > 0.0 ? cloud[k] / cloud_weight[k] : vec4(0.0, 0.0, 0.0, 1.0);
    vec4 premultiplied = texelFetch(cloud_radiance, pixel, 0), near = texelFetch(cloud_near, pixel, 0);
    vec3 light = near.rgb * cloud[0].a + cloud[0].rgb * near.a + (premultiplied.rgb - near.rgb) * cloud[1].a + cloud[1].rgb * (1.0 - premultiplied.a - near.a);
    imageStore(out_cloud, pixel, vec4(max(within_rec709(light), vec3(0.0)), premultiplied.a));
  }
}
