// Straight flights of light over the curved Earth, in steps: places and heights along them without differences of large floats.
//
// Needs CLOUD_PLANET (a PlanetView).
#ifndef NEPHO_CLOUDS_FLIGHT_GLSL
#define NEPHO_CLOUDS_FLIGHT_GLSL
#include "common/planet.h"

const float kFar_m = 1.0e9;

// A point given by its direction from the Earth's centre (scaled space) and its geodetic height, camera-relative: to half a metre.
vec3 point_at(PlanetView planet, vec3 dir, float height_m) {
  vec3 q = dir * (planet.a_m + scaled_height_from_geodetic(planet, dir, height_m));
  vec3 d = (q - planet.camera_q_m) - planet.camera_q_low_m;
  return vec3(d.xy, d.z / planet.a_over_b);
}

// A straight flight of a path. Heights follow from f = |q|^2 - a^2, quadratic along it (planet.h).
struct Flight {
  vec3 origin, dir;
  vec3 q0, scaled_dir;
  float f0, slope, bend;  // f = f0 + s (slope + s bend)
  float s;                // where it is, m
  float end_m;            // where the surface is; kFar_m: nowhere
  float left;             // optical depth of majorant to the next tentative collision
};

struct Place {
  vec3 up;         // geodetic normal
  vec3 dir;        // from the centre, scaled space
  float inv_q;     // 1 / |q|
  float height_m;  // geodetic
};

Place place_on(Flight f) {
  vec3 q = f.q0 + f.scaled_dir * f.s;
  Place p;
  float len2 = dot(q, q);
  p.inv_q = inversesqrt(len2);
  p.dir = q * p.inv_q;
  vec3 sq = vec3(q.xy, q.z * CLOUD_PLANET.a_over_b);
  float inv = inversesqrt(dot(sq, sq));
  p.up = sq * inv;
  p.height_m = scaled_height_from_f(CLOUD_PLANET, f.f0 + f.s * (f.slope + f.s * f.bend)) * (len2 * p.inv_q * inv);
  return p;
}

// Along `dir` from a camera-relative point, without a surface.
Flight flight_from(vec3 origin, vec3 dir) {
  Flight f;
  f.origin = origin;
  f.dir = dir;
  f.q0 = planet_q(CLOUD_PLANET, origin);
  f.scaled_dir = scaled_from_cam(CLOUD_PLANET, dir);
  f.f0 = planet_f_from_q(CLOUD_PLANET, origin, f.q0);
  f.slope = 2.0 * dot(f.q0, f.scaled_dir);
  f.bend = dot(f.scaled_dir, f.scaled_dir);
  f.s = 0.0;
  f.end_m = kFar_m;
  f.left = 0.0;
  return f;
}

// Distance to a shell of scaled height h from above; 0 from below it when the flight descends, kFar_m when it does not meet it.
float distance_to_shell(Flight f, float h_m) {
  float c = f.f0 - h_m * (2.0 * CLOUD_PLANET.a_m + h_m), b = -0.5 * f.slope;
  if (b <= 0.0) return kFar_m;
  float root = b * b - f.bend * c;
  if (root < 0.0) return kFar_m;
  return max(c, 0.0) / (b + sqrt(root));
}

// Length over which a ray rises by dz, and sinks by dz (kFar_m: it does not), climbing by `climb` a metre where it is.
float length_rising(float dz, float climb) {
  float root = sqrt(climb * climb + 2.0 * dz / CLOUD_PLANET.a_m);
  return climb >= 0.0 ? 2.0 * dz / (climb + root) : CLOUD_PLANET.a_m * (root - climb);
}
float length_sinking(float dz, float climb) {
  float root = climb * climb - 2.0 * dz / CLOUD_PLANET.a_m;
  return climb >= 0.0 || root < 0.0 ? kFar_m : 2.0 * dz / (sqrt(root) - climb);
}

#endif
