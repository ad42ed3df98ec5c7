// The exact ellipsoid in single precision (docs/units_and_frames.md, 'Scaled space').
//
// With S = diag(1, 1, a/b) and q = S p the ellipsoid is a sphere of radius a and straight rays stay straight.
// |q|^2 - a^2 = (|q0|^2 - a^2) + dq.(q0 + q) for q = q0 + dq, the first term computed in double on the CPU, so
// no difference of two large floats is taken near the camera. Heights: (|q| - a) / (q^ . S n^) with n^ ~ S q the
// geodetic normal, so that q^ . S n^ = |q| / |S q| * (q.S S q) / |q|^2 = |S q| / |q|.
#ifndef NEPHO_COMMON_PLANET_H
#define NEPHO_COMMON_PLANET_H
#include "common/shared.h"
SHARED_BEGIN

// The planet as seen from the camera. Filled by make_planet_view() (src/geo/planet_view.h).
struct PlanetView {
  vec3 camera_q_m;        // S * camera position, ECEF axes, m
  float a_m;              // equatorial radius: the sphere's radius in scaled space, m
  vec3 camera_q_low_m;    // what rounding to float took from camera_q_m (2 m at a geostationary camera)
  float a_over_b;         // stretch of z in scaled space; 1 for a sphere
  float stretch;          // a_over_b - 1, from double
  float camera_f_m2;      // |camera_q|^2 - a^2, from double, m^2
  float camera_height_m;  // geodetic height of the camera, from double, m
  float pad0;
};

// Beyond this distance from the camera the camera's own rounding costs more than that of |q|^2 - a^2 (0.4 m). m^2.
SHARED_CONST float kPlanetFar_m2 = 9.0e12f;

SHARED_FN vec3 scaled_from_cam(PlanetView planet, vec3 v) { return vec3(v.x, v.y, v.z * planet.a_over_b); }

// Scaled geocentric position of a camera-relative point, m, to half a metre near the Earth from any camera: the two
// large parts nearly cancel and are added first (exactly, from space), then the small ones.
SHARED_FN vec3 planet_q(PlanetView planet, vec3 point_cam_m) {
  return (planet.camera_q_m + point_cam_m) + (planet.camera_q_low_m + vec3(0.0f, 0.0f, point_cam_m.z * planet.stretch));
}

// |q|^2 - a^2 at a camera-relative point, m^2, q its planet_q().
SHARED_FN float planet_f_from_q(PlanetView planet, vec3 point_cam_m, vec3 q) {
  vec3 dq = scaled_from_cam(planet, point_cam_m);
  float near_f = planet.camera_f_m2 + dot(dq, planet.camera_q_m + q);
  float far_f = dot(q, q) - planet.a_m * planet.a_m;
  return dot(dq, dq) < kPlanetFar_m2 ? near_f : far_f;
}

SHARED_FN float planet_f(PlanetView planet, vec3 point_cam_m) {
  return planet_f_from_q(planet, point_cam_m, planet_q(planet, point_cam_m));
}

// |q| - a: height in scaled space, m. Equals the geodetic height at the equator, 1.00336 times it at the poles.
SHARED_FN float scaled_height_from_f(PlanetView planet, float f) {
  return f / (planet.a_m + sqrt(max(planet.a_m * planet.a_m + f, 0.0f)));
}

// Unit geodetic normal at a camera-relative point: S q normalised. Exact on the ellipsoid; 2e-4 rad off at 400 km,
// where the vertical through the point meets the ellipsoid elsewhere than the scaled radius does.
SHARED_FN vec3 geodetic_up(PlanetView planet, vec3 point_cam_m) {
  vec3 q = planet_q(planet, point_cam_m);
  return normalize(vec3(q.x, q.y, q.z * planet.a_over_b));
}

// Geodetic height of a camera-relative point, m: the formula is off by 0.1 mm at 10 km, 13 cm at 400 km; rounding adds
// 1e-7 of the distance from the camera, 1 m at most.
SHARED_FN float geodetic_height(PlanetView planet, vec3 point_cam_m) {
  vec3 q = planet_q(planet, point_cam_m);
  vec3 sq = vec3(q.x, q.y, q.z * planet.a_over_b);
  float h = scaled_height_from_f(planet, planet_f_from_q(planet, point_cam_m, q));
  return h * sqrt(dot(q, q) / dot(sq, sq));
}

// Scaled height of the shell that has geodetic height `height_m` where the direction q (any length) meets it, m.
SHARED_FN float scaled_height_from_geodetic(PlanetView planet, vec3 q, float height_m) {
  vec3 sq = vec3(q.x, q.y, q.z * planet.a_over_b);
  return height_m * sqrt(dot(sq, sq) / dot(q, q));
}

// Distances (m along `dir`, in units of its length) at which the ray from the camera crosses the surface at scaled
// height `shell_height_m`; false when it misses. t.x <= t.y, either may be negative (behind).
SHARED_FN bool intersect_shell(PlanetView planet, vec3 dir, float shell_height_m, SHARED_OUT(vec2) t) {
  vec3 sd = scaled_from_cam(planet, dir);
  float a = dot(sd, sd);
  float b = dot(planet.camera_q_m, sd);
  // |q0|^2 - R^2 without cancellation: (|q0|^2 - a^2) - H (2 a + H).
  float c = planet.camera_f_m2 - shell_height_m * (2.0f * planet.a_m + shell_height_m);
  // b^2 - a c as a (R^2 - |perpendicular|^2): the perpendicular part is found by subtraction of vectors, which keeps
  // its precision when b^2 and a c are both large (far out in space, or straight up and down); the direct form keeps
  // it when both are small (horizontal views near the ground).
  vec3 perpendicular = planet.camera_q_m - sd * (b / a);
  float r = planet.a_m + shell_height_m;
  float outside = a * (r * r - dot(perpendicular, perpendicular));
  float direct = b * b - a * c;
  float discriminant = b * b > 0.25f * a * r * r ? outside : direct;
  t = vec2(0.0f, 0.0f);
  if (discriminant < 0.0f) return false;
  float root = sqrt(discriminant);
  // The root of larger magnitude first, the other from the product of the roots.
  float w = b > 0.0f ? -(b + root) : root - b;
  float t0 = w / a;
  float t1 = w != 0.0f ? c / w : t0;
  t = vec2(min(t0, t1), max(t0, t1));
  return true;
}

SHARED_END
#endif
