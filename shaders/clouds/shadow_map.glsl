// How much of the key light (the sun; at night the moon) passes the clouds between it and any point: on the ground, in the
// air, inside clouds. From the shadow maps (docs/light.md): four texels are read, or eight where one map gives way to the
// next. Define CLOUD_SHADOW_BINDING for the first of two bindings, 30 unless said; bind_cloud_shadow() fills them
// (src/clouds/shadow_map.h).
//
// Needs `frame` (FrameConstants in frame.frame_data) declared before, or CLOUD_PLANET defined.
#ifndef NEPHO_SHADOW_MAP_GLSL
#define NEPHO_SHADOW_MAP_GLSL
#include "clouds/shadow_map_shared.h"
#include "common/planet.h"
#ifndef CLOUD_SHADOW_BINDING
#define CLOUD_SHADOW_BINDING 30
#endif
#ifndef CLOUD_PLANET
#define CLOUD_PLANET frame.frame_data.planet
#endif
layout(scalar, set = 0, binding = CLOUD_SHADOW_BINDING) uniform ShadowBlock { ShadowMaps data; } cloud_shadow;
layout(set = 0, binding = CLOUD_SHADOW_BINDING + 1) uniform usampler2DArray cloud_shadow_map;
#define SHADOW cloud_shadow.data

// Place of a point in a cascade's window: x, y in texels, z the stored depth.
vec3 shadow_point(ShadowCascade c, vec3 p_cam) {
  vec3 d = p_cam - c.corner;
  return vec3(vec2(dot(d, SHADOW.axis_x), dot(d, SHADOW.axis_y)) / c.texel_m, 32768.0 - dot(d, SHADOW.light) / c.depth_unit_m);
}

// The first cascade from `first` on that has a point in it; SHADOW.cascades where none has.
uint shadow_cascade_at(vec3 p_cam, float distance_m, uint first) {
  uint best = SHADOW.cascades, tiles = SHADOW.resolution / kShadowTile;
  for (uint i = kShadowCascades; i > 0u; --i) {
    uint k = i - 1u;
    if (k < first || k >= SHADOW.cascades) continue;
    uvec2 tile = uvec2(clamp(shadow_point(SHADOW.at[k], p_cam).xy / float(kShadowTile), vec2(0.0), vec2(float(tiles) - 0.5)));
    uint bit = tile.y * tiles + tile.x;
    if (distance_m < SHADOW.at[k].reach_m && (SHADOW.usable[k * kShadowWords + (bit >> 5)] >> (bit & 31u) & 1u) != 0u) best = k;
  }
  return best;
}

// Transmittance by one cascade, between the four texels around a point; `shift` moves them, in texels, for filters.
float shadow_read(uint k, vec3 p_cam, vec2 shift) {
  ShadowCascade c = SHADOW.at[k];
  vec3 at = shadow_point(c, p_cam);
  at.xy += shift - 0.5;
  vec2 whole = floor(at.xy), part = at.xy - whole;
  uvec2 low = uvec2(clamp(whole, vec2(0.0), vec2(float(SHADOW.resolution) - 2.0)));
  // Texels that are wide against the layer are asked at the point's height, not at its depth: across them the layer rises
  // towards the light by more than it is thick.
  vec3 up = geodetic_up(CLOUD_PLANET, p_cam);
  float flat_part = clamp(5.0 * c.texel_m / SHADOW.thickness_m - 0.5, 0.0, 1.0);
  vec2 rise = vec2(dot(up, SHADOW.axis_x), dot(up, SHADOW.axis_y)) * (flat_part * c.texel_m / (max(dot(up, SHADOW.light), 0.05) * c.depth_unit_m));
  float sum = 0.0, depth = 0.0, behind = 0.0;
  for (uint i = 0u; i < 4u; ++i) {
    uvec2 corner = uvec2(i & 1u, i >> 1);
    uvec4 texel = texelFetch(cloud_shadow_map, ivec3(shadow_place(c, low + corner, SHADOW.resolution), k), 0);
    vec2 w = mix(1.0 - part, part, vec2(corner));
    float x = clamp(at.z + dot(rise, vec2(corner) - part), 0.0, 65535.0);
    float tau = shadow_depth_at(texel, x);
    sum += w.x * w.y * exp(-tau);
    depth += w.x * w.y * tau;
    if (x > float(texel.w >> 16u)) behind += w.x * w.y;
  }
  // Means of transmittances are too bright inside clouds, at their slanting faces; means of optical depths are too dark behind
  // them, at their rims: there, half of each.
  return mix(exp(-depth), sum, 0.5 * behind);
}

// Where no map is: the mean below the clouds, nothing above them.
float shadow_outside(vec3 p_cam) {
  float height_m = geodetic_height(CLOUD_PLANET, p_cam);
  float below = shadow_beyond(SHADOW.outside, SHADOW.slant, dot(geodetic_up(CLOUD_PLANET, p_cam), SHADOW.light));
  return mix(below, 1.0, clamp((height_m - SHADOW.hull_low_m) / (SHADOW.hull_high_m - SHADOW.hull_low_m), 0.0, 1.0));
}

// p_cam: camera-relative point, ECEF axes, m. 1 where nothing is between it and the light. Whether the Earth is in the way
// is another matter.
float cloud_sun_transmittance(vec3 p_cam) {
  if (SHADOW.cascades == 0u) return 1.0;
  float distance_m = length(p_cam), sum = 0.0, left = 1.0;
  uint k = shadow_cascade_at(p_cam, distance_m, 0u);
  while (left > 0.0) {
    bool none = k >= SHADOW.cascades;
    ShadowCascade c = SHADOW.at[min(k, SHADOW.cascades - 1u)];
    float share = none ? left : left * clamp((c.reach_m - distance_m) / (c.reach_m - c.fade_m), 0.0, 1.0);
    sum += share * (none ? shadow_outside(p_cam) : shadow_read(k, p_cam, vec2(0.0)));
    left -= share;
    if (left > 0.0) k = shadow_cascade_at(p_cam, distance_m, k + 1u);
  }
  return sum;
}

// The same as an optical depth, at most kShadowDeepest.
float cloud_sun_optical_depth(vec3 p_cam) { return min(-log(max(cloud_sun_transmittance(p_cam), 1.0e-6)), kShadowDeepest); }

#endif
