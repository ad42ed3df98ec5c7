#version 460
#extension GL_GOOGLE_include_directive : require
// Shafts of the picture alone: the air of a pixel is as sunlit as the picture is open from there to the sun. A point of a ray sees the sun through
// what the picture shows between the pixel and the sun: close to the sun for points close to the camera.
#include "common/frame.h"
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define ATMOSPHERE_BINDING 12
#include "atmosphere/atmosphere_lookup.glsl"
#include "render/night_sky_shared.h"
layout(set = 0, binding = 26) uniform sampler2D cloud_radiance;  // a: transmittance
#define SHAFT_BINDING 19
float screen_visible;  // share of the sun for the block at hand
#define TERRAIN_VOLUME_BINDING 40
#define TERRAIN_CONSTANT 9
#include "terrain/terrain_air.glsl"
#define AIR_VISIBLE(p) (screen_visible * terrain_air_share(p))
#define AIR_BLOCK(block) screen_visible = screen_visibility(block);
#define AIR_RAY(dir)
#define AIR_LOOK(t, number) 1.0
#define AIR_LOOKS 1
#define AIR_GLOW
#include "render/shaft_air.glsl"
layout(constant_id = 8) const uint BLUR_STEPS = 32u;
float screen_visibility(ivec2 block);
#include "render/shaft_march.glsl"

// Mean of the clouds' transmittance from the block to the sun's place; surfaces do not count. 1 where the sun is far outside the picture.
float screen_visibility(ivec2 block) {
  FrameConstants f = frame.frame_data;
  vec2 size = vec2(f.size), pixel = (vec2(block) + 0.5) * vec2(push.block), sun;
  bool ahead = pixel_from_direction(f, f.key_dir, sun);
  vec2 outside = max(abs(sun - 0.5 * size) - 0.5 * size, vec2(0.0)) / size.y;
  float fade = ahead ? 1.0 - smoothstep(0.3, 1.0, length(outside)) : 0.0;
  // Neighbouring blocks take different points.
  float shift = fract(52.9829189 * fract(dot(vec2(block), vec2(0.06711056, 0.00583715))));
  float open = 0.0, count = 1.0e-3;
  for (uint i = 0u; i < BLUR_STEPS; ++i) {
    vec2 at = mix(pixel, sun, (float(i) + shift) / float(BLUR_STEPS));
    ivec2 texel = clamp(ivec2(at), ivec2(0), ivec2(f.size) - 1);
    bool inside = all(equal(texel, ivec2(floor(at)))) && texelFetch(depth_m, texel, 0).r > 0.5 * kFarDepth_m;
    open += inside ? texelFetch(cloud_radiance, texel, 0).a : 0.0;
    count += inside ? 1.0 : 0.0;
  }
  return mix(1.0, (open + 1.0e-3) / count, fade);
}
