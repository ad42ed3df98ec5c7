#version 460
#extension GL_GOOGLE_include_directive : require
// Puts the change that shade and haze make, known for blocks of pixels, on the background and on the clouds.
#include "common/frame.h"
#include "common/gamut.h"
#include "render/shaft_shared.h"
layout(local_size_x = 16, local_size_y = 16) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1) uniform sampler2D depth_m;
layout(set = 0, binding = 2) uniform sampler2D cloud_info;
layout(set = 0, binding = 3) uniform sampler2D near_tex;
layout(set = 0, binding = 4) uniform sampler2D far_tex;
layout(set = 0, binding = 5) uniform sampler2D cloud_tex;
layout(set = 0, binding = 6) uniform sampler2D depths_tex;
layout(set = 0, binding = 7) uniform sampler2D background;
layout(set = 0, binding = 8) uniform sampler2D cloud_radiance;
layout(set = 0, binding = 9, rgba32f) uniform writeonly image2D out_background;
layout(set = 0, binding = 10, rgba32f) uniform writeonly image2D out_cloud;
layout(push_constant, scalar) uniform PushBlock { ShaftApplyPush push; };

void main() {
  FrameConstants f = frame.frame_data;
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, ivec2(f.size)))) return;
  float distance = shaft_depth(min(texelFetch(depth_m, pixel, 0).r, kFarDepth_m));
  vec4 info = texelFetch(cloud_info, pixel, 0);
  float cloud_distance = shaft_depth(info.x);
  vec2 place = (vec2(pixel) + 0.5) / float(push.downscale) - 0.5;
  ivec2 low = ivec2(floor(place)), last = textureSize(depths_tex, 0) - 1;
  vec2 part = place - vec2(low);
  vec4 behind = vec4(0.0), cloud = vec4(0.0);
  float behind_weight = 0.0, cloud_weight = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = ivec2(i & 1, i >> 1);
    ivec2 at = clamp(low + corner, ivec2(0), last);
    vec2 w = mix(1.0 - part, part, vec2(corner));
    float weight = w.x * w.y + 1.0e-4;
    vec4 depths = texelFetch(depths_tex, at, 0);
    float nearest = shaft_depth(depths.x), farthest = shaft_depth(depths.y);
    // Between the block's nearest and farthest surface; blocks that have nothing at this distance count little.
    float u = clamp((distance - nearest) / max(farthest - nearest, 1.0e-6), 0.0, 1.0);
    float off = distance - clamp(distance, nearest, farthest);
    float w_behind = weight / (1.0 + 1.0e4 * off * off);
    behind += w_behind * mix(texelFetch(near_tex, at, 0), texelFetch(far_tex, at, 0), u);
    behind_weight += w_behind;
    off = cloud_distance - shaft_depth(depths.z);
    float w_cloud = depths.z > 0.0 ? weight / (1.0 + 1.0e4 * off * off) : 0.0;
    cloud += w_cloud * texelFetch(cloud_tex, at, 0);
    cloud_weight += w_cloud;
  }
  behind /= behind_weight;
  vec3 seen = texelFetch(background, pixel, 0).rgb;
  imageStore(out_background, pixel, vec4(max(within_rec709(seen * behind.a + behind.rgb), vec3(0.0)), 1.0));
  if (push.has_clouds != 0u) {
    cloud = cloud_weight > 0.0 ? cloud / cloud_weight : vec4(0.0, 0.0, 0.0, 1.0);
    vec4 premultiplied = texelFetch(cloud_radiance, pixel, 0);
    vec3 light = premultiplied.rgb * cloud.a + cloud.rgb * (1.0 - premultiplied.a);
    imageStore(out_cloud, pixel, vec4(max(within_rec709(light), vec3(0.0)), premultiplied.a));
  }
}
