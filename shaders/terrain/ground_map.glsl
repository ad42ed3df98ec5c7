// The ground around a place, coarse (src/terrain/ground_map.h).
//
//   #define GROUND_MAP_BINDING 12     // takes this binding and the next: ground_albedo_tex, ground_height_tex
//   #include "terrain/ground_map.glsl"
#ifndef NEPHO_TERRAIN_GROUND_MAP_GLSL
#define NEPHO_TERRAIN_GROUND_MAP_GLSL
#include "common/region_map.h"
layout(set = 0, binding = GROUND_MAP_BINDING) uniform sampler2DArray ground_albedo_tex;
layout(set = 0, binding = GROUND_MAP_BINDING + 1) uniform sampler2DArray ground_height_tex;

struct GroundPoint {
  vec3 albedo;     // of its land, linear Rec. 709; black where there is none
  float water;     // share, 0..1
  float height_m;  // of the drawn surface above the ellipsoid
};

// Layer and place of a direction on the finest level among whose texel centres it lies; beyond the last level, its rim.
vec3 ground_uvw(RegionMap map, vec3 dir) {
  float texels = float(textureSize(ground_height_tex, 0).x);
  vec2 xy = region_xy(map, dir);
  uint level = min(region_level(map, xy * (texels / (texels - 1.0))), map.levels - 1u);
  return vec3(xy * (0.5 / region_half_m(map, level)) + 0.5, float(level));
}

// `dir`: a unit vector of scaled space, normalize(S p).
GroundPoint ground_at(RegionMap map, vec3 dir) {
  vec3 uvw = ground_uvw(map, dir);
  vec4 land = textureLod(ground_albedo_tex, uvw, 0.0);
  GroundPoint g;
  g.albedo = min(land.rgb / max(land.a, 1.0e-4), vec3(1.0));
  g.water = 1.0 - land.a;
  g.height_m = textureLod(ground_height_tex, uvw, 0.0).r;
  return g;
}

// The height alone: half the reads.
float ground_height_m(RegionMap map, vec3 dir) { return textureLod(ground_height_tex, ground_uvw(map, dir), 0.0).r; }

#endif
