// Nested square maps around a place: level k is twice as wide as level k - 1, with as many texels. For what is needed finely
// near a place and coarsely as far as the horizon.
//
// The plane is Lambert's azimuthal equal-area projection of the scaled sphere (docs/units_and_frames.md, 'Scaled space') about
// `centre`: for a unit vector d at the angle theta from the centre, r = 2 R sin(theta / 2). Lengths along the radius are
// scaled by cos(theta / 2), across it by 1 / cos(theta / 2).
#ifndef NEPHO_COMMON_REGION_MAP_H
#define NEPHO_COMMON_REGION_MAP_H
#include "common/shared.h"
SHARED_BEGIN

struct RegionMap {
  vec3 centre;     // unit vectors of scaled space: the place, east and north there (any pair across the poles)
  float half_m;    // half the side of level 0
  vec3 east;
  float radius_m;  // of the scaled sphere
  vec3 north;
  uint levels;
};

// Place of a unit vector of scaled space on the plane, m: x east, y north. The antipode is a whole circle: one place of it
// is returned.
SHARED_FN vec2 region_xy(RegionMap map, vec3 dir) {
  float up = dot(dir, map.centre);
  vec2 side = vec2(dot(dir, map.east), dot(dir, map.north));
  float sin2 = dot(side, side);
  if (up < 0.0f && sin2 < 1.0e-12f) return vec2(2.0f * map.radius_m, 0.0f);  // within 6 m of the antipode
  float open = up > 0.0f ? 1.0f + up : sin2 / (1.0f - up);  // the same, but 1 + up loses its digits far out
  return side * (map.radius_m * sqrt(2.0f / open));
}

// The inverse. Beyond 2 R there is nothing; the antipode is returned.
SHARED_FN vec3 region_direction(RegionMap map, vec2 xy) {
  float r2 = min(dot(xy, xy) / (map.radius_m * map.radius_m), 4.0f);
  float up = 1.0f - 0.5f * r2;                      // cos theta
  float side = sqrt(max(1.0f - 0.25f * r2, 0.0f));  // sin theta / r
  vec2 t = xy * (side / map.radius_m);
  return normalize(map.centre * up + map.east * t.x + map.north * t.y);
}

// Most that the projection lengthens distances at dir.
SHARED_FN float region_stretch(RegionMap map, vec3 dir) {
  return sqrt(2.0f / max(1.0f + dot(dir, map.centre), 1.0e-3f));
}

// The finest level that holds xy; `levels` where none does.
SHARED_FN uint region_level(RegionMap map, vec2 xy) {
  float most = max(abs(xy.x), abs(xy.y));
  float half_m = map.half_m;
  uint k = 0u;
  for (; k < map.levels && most >= half_m; ++k) half_m *= 2.0f;
  return k;
}

SHARED_FN float region_half_m(RegionMap map, uint level) { return map.half_m * exp2(float(level)); }

SHARED_END
#endif
