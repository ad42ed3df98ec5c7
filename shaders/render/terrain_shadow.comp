#version 460
#extension GL_GOOGLE_include_directive : require
// Share of the key light that reaches the surface of every pixel past terrain, times that through clouds.
#include "common/frame.h"
layout(local_size_x = 16, local_size_y = 16) in;  // a tile
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define TERRAIN_SHADOW_BINDING 1
#include "terrain/terrain_shadow.glsl"
layout(set = 0, binding = 3) uniform sampler2D depth_m;
layout(set = 0, binding = 4) uniform sampler2D cloud_share;  // CLOUDS
layout(set = 0, binding = 5, r32f) uniform writeonly image2D sun_visibility;
#define PIXEL_TILES_BINDING 6
#include "common/pixel_tiles.glsl"
layout(set = 0, binding = 7) uniform sampler2DArray terrain_lit_tex;
layout(constant_id = 0) const bool CLOUDS = false;

// Whether shadows are far from a point (terrain_lit.comp).
bool surely_lit(vec3 point) {
  RegionMap map = terrain_shadow.data.map;
  vec2 xy = region_xy(map, normalize(planet_q(frame.frame_data.planet, point)));
  float away = max(abs(xy.x), abs(xy.y)) * (float(kShadowTexels) / float(kShadowTexels - 1u));
  float level = max(floor(log2(max(away / map.half_m, 0.5))) + 1.0, 0.0);
  if (level >= float(map.levels)) return false;
  vec2 uv = xy * (0.5 / (map.half_m * exp2(level))) + 0.5;
  return texelFetch(terrain_lit_tex, ivec3(clamp(ivec2(uv * float(kShadowTexels)), ivec2(0), ivec2(kShadowTexels - 1u)), int(level)), 0).r > 0.0;
}

void main() {
  ivec2 pixel = ivec2(tile_pixel());
  if (any(greaterThanEqual(pixel, ivec2(frame.frame_data.size)))) return;
  float distance = texelFetch(depth_m, pixel, 0).r;
  bool surface = distance < 0.5 * kFarDepth_m;
  float share = surface && CLOUDS ? texelFetch(cloud_share, pixel, 0).r : 1.0;
  vec3 point = pixel_direction(frame.frame_data, vec2(pixel) + 0.5) * distance;
  if (surface && share > 0.0 && !surely_lit(point)) share *= terrain_sun_share(point);
  imageStore(sun_visibility, pixel, vec4(share));
}
