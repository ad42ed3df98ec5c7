// Share of the key light's disc that terrain leaves visible from a point (docs/light.md, 'Terrain shadows').
//
//   #define TERRAIN_SHADOW_BINDING 12   // takes this binding and the next: terrain_shadow_tex, terrain_shadow
//   #include "terrain/terrain_shadow.glsl"
//
// Needs `frame` (FrameConstants in frame.frame_data) declared before.
#ifndef NEPHO_TERRAIN_TERRAIN_SHADOW_GLSL
#define NEPHO_TERRAIN_TERRAIN_SHADOW_GLSL
#include "common/frame.h"
#include "terrain/terrain_shadow_shared.h"
layout(set = 0, binding = TERRAIN_SHADOW_BINDING) uniform sampler2DArray terrain_shadow_tex;
layout(scalar, set = 0, binding = TERRAIN_SHADOW_BINDING + 1) uniform TerrainShadowBlock { TerrainShadowConstants data; } terrain_shadow;

const int kTerrainShadowSteps = 224;

// Camera-relative point, ECEF axes; below the map's ground it is lifted onto it. What the planet itself hides of the disc from
// that height is the atmosphere's (sun_share of atmosphere_shared.h): it is divided out.
float terrain_sun_share(vec3 point) {
  PlanetView planet = frame.frame_data.planet;
  RegionMap map = terrain_shadow.data.map;
  float highest = terrain_shadow.data.highest_m, radius = frame.frame_data.sun_angular_radius_rad;
  vec3 light = frame.frame_data.key_dir;
  vec3 q0 = planet_q(planet, point), scaled_light = scaled_from_cam(planet, light);
  // Height along the ray follows from what f = |q|^2 - a^2 gains: no two large numbers are subtracted.
  float f0 = planet_f_from_q(planet, point, q0), slope = 2.0 * dot(q0, scaled_light), bend = dot(scaled_light, scaled_light);
  float root0 = sqrt(planet.a_m * planet.a_m + f0);
  float start_m = geodetic_height(planet, point), height_m = start_m;
  float least = 1.0;  // clearance so far, in radii of the disc
  float t = 0.0, rising0 = 0.0;
  int mip = 0;
  for (int i = 0; i < kTerrainShadowSteps; ++i) {
    vec3 q = q0 + scaled_light * t;
    vec3 sq = vec3(q.xy, q.z * planet.a_over_b);
    float inv = inversesqrt(dot(sq, sq)), gained = t * (slope + t * bend);
    vec3 up = sq * inv;
    height_m = start_m + gained / (root0 + sqrt(planet.a_m * planet.a_m + f0 + gained)) * (length(q) * inv);
    float rising = dot(up, light);
    vec3 dir = normalize(q);
    vec2 xy = region_xy(map, dir);
    float away = max(abs(xy.x), abs(xy.y));
    // The finest level among whose texel centres the place is.
    float level = max(floor(log2(max(away * (float(kShadowTexels) / float(kShadowTexels - 1u)) / map.half_m, 0.5))) + 1.0, 0.0);
    if (level >= float(map.levels)) break;  // beyond the map the Earth is smooth
    float half_m = map.half_m * exp2(level), texel_m = 2.0 * half_m / float(kShadowTexels);
    vec2 uv = xy * (0.5 / half_m) + 0.5;
    if (i == 0) {
      start_m = max(start_m, textureLod(terrain_shadow_tex, vec3(uv, level), 0.0).r);
      rising0 = rising;
    }
    // Metres of the ray to a metre of the map.
    float per_m = 1.0 / max(sqrt(max(1.0 - rising * rising, 0.0)) * region_stretch(map, dir) * 1.004, 0.02);
    if (i > 0) {
      // Nothing in front of it is so high.
      if (rising > radius && height_m - highest > radius * t) break;
      if (mip == 0) {
        float clear = (height_m - textureLod(terrain_shadow_tex, vec3(uv, level), 0.0).r) / (t * radius);
        least = min(least, clear);
        if (least <= -1.0) break;
        mip = clear > least + 2.0 ? 1 : 0;
      } else {
        ivec2 cell = clamp(ivec2(uv * float(kShadowTexels)), ivec2(0), ivec2(kShadowTexels - 1u)) >> mip;
        float top = texelFetch(terrain_shadow_tex, ivec3(cell, int(level)), mip).r;
        float ahead = texel_m * exp2(float(mip)) * per_m;
        float clear_m = min(height_m, height_m + rising * ahead) - top;
        if (clear_m > least * radius * (clear_m > 0.0 ? t + ahead : t)) {
          // Nor is anything within the cell's width; but beyond its level nobody looked.
          t += min(ahead, (half_m - away + texel_m) * per_m);
          mip = min(mip + 1, int(kShadowMips) - 1);
          continue;
        }
        --mip;
        continue;
      }
    }
    t += max((i > 0 ? 0.5 : 1.0) * texel_m * per_m, 0.002 * t);  // crests are between texels
  }
  // Above the planet's own horizon, dipped by the height.
  float whole = disc_share((asin(clamp(rising0, -1.0, 1.0)) + sqrt(2.0 * max(start_m, 0.0) / planet.a_m)) / radius);
  return whole > 0.0 ? min(disc_share(least) / whole, 1.0) : 1.0;
}

#endif
