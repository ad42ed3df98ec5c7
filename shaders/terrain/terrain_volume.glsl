// Share of the key light's disc that terrain leaves visible from a point of the air, by one read of the map of shadow heights
// (terrain_volume.comp; docs/light.md, 'Terrain shadows in the air'). For the ground itself: terrain_shadow.glsl.
//
//   #define TERRAIN_VOLUME_BINDING 40   // takes this binding and the next: terrain_volume_tex, terrain_volume
//   #include "terrain/terrain_volume.glsl"
//
// Needs `frame` (FrameConstants in frame.frame_data) declared before.
#ifndef NEPHO_TERRAIN_TERRAIN_VOLUME_GLSL
#define NEPHO_TERRAIN_TERRAIN_VOLUME_GLSL
#include "common/frame.h"
#include "terrain/terrain_shadow_shared.h"
layout(set = 0, binding = TERRAIN_VOLUME_BINDING) uniform sampler2DArray terrain_volume_tex;
layout(scalar, set = 0, binding = TERRAIN_VOLUME_BINDING + 1) uniform TerrainVolumeBlock { RegionMap map; } terrain_volume;

// Camera-relative point, ECEF axes. What the planet itself hides of the disc is the atmosphere's: it is divided out.
float terrain_volume_share(vec3 point) {
  PlanetView planet = frame.frame_data.planet;
  RegionMap map = terrain_volume.map;
  vec3 q = planet_q(planet, point);
  vec2 xy = region_xy(map, normalize(q));
  float away = max(abs(xy.x), abs(xy.y));
  float level = max(floor(log2(max(away * (float(kShadowTexels) / float(kShadowTexels - 1u)) / map.half_m, 0.5))) + 1.0, 0.0);
  vec4 edge = textureLod(terrain_volume_tex, vec3(xy * (0.5 / (map.half_m * exp2(level))) + 0.5, min(level, float(map.levels - 1u))), 0.0);
  float height_m = geodetic_height(planet, point);
  float share = disc_share(min((height_m - edge.x) / edge.y, (height_m - edge.z) / edge.w));
  float elevation = asin(clamp(dot(geodetic_up(planet, point), frame.frame_data.key_dir), -1.0, 1.0));
  float whole = disc_share((elevation + sqrt(2.0 * max(height_m, 0.0) / planet.a_m)) / frame.frame_data.sun_angular_radius_rad);
  // Beyond the map the Earth is smooth.
  return level < float(map.levels) && whole > 0.0 ? min(share / whole, 1.0) : 1.0;
}

#endif
