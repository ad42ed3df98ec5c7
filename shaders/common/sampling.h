// Directions drawn from distributions. u values are uniform in [0, 1).
#ifndef NEPHO_COMMON_SAMPLING_H
#define NEPHO_COMMON_SAMPLING_H
#include "common/phase.h"
SHARED_BEGIN

// A unit vector across the unit vector n (Duff et al. 2017, JCGT 6(1)).
SHARED_FN vec3 tangent_of(vec3 n) {
  float s = n.z < 0.0f ? -1.0f : 1.0f;
  float a = -1.0f / (s + n.z);
  return vec3(1.0f + s * n.x * n.x * a, s * n.x * n.y * a, -s * n.x);
}

// The unit vector at an angle from the unit vector axis, turned about it by 2 pi u.
SHARED_FN vec3 direction_turned(vec3 axis, float cos_theta, float sin_theta, float u) {
  float phi = 2.0f * kPi * u;
  vec3 t = tangent_of(axis);
  vec3 b = cross(axis, t);
  return normalize(axis * cos_theta + (t * cos(phi) + b * sin(phi)) * sin_theta);
}

SHARED_FN vec3 direction_about(vec3 axis, float cos_theta, float u) {
  return direction_turned(axis, cos_theta, sqrt(max(1.0f - cos_theta * cos_theta, 0.0f)), u);
}

// Cosine of the scattering angle of Henyey-Greenstein, -1 < g < 1, by inversion (u = 0 is straight on). Witt's (1977) formula
// multiplied out, so that no small g is divided by.
SHARED_FN float sample_hg_cosine(float g, float u) {
  float x = 1.0f - 2.0f * u;
  float t = 1.0f + g * x;
  return clamp((x + g * (0.5f * x * x + 1.5f + g * (x + 0.5f * g * (x * x - 1.0f)))) / (t * t), -1.0f, 1.0f);
}

// The same of two lobes: u decides the lobe, and what is left of it the angle.
SHARED_FN float sample_dual_hg_cosine(float g0, float g1, float w, float u) {
  if (u < w) return sample_hg_cosine(g1, min(u / w, 0.99999994f));
  return sample_hg_cosine(g0, min((u - w) / (1.0f - w), 0.99999994f));
}

// Cosine-weighted over the hemisphere about n: density cos / pi.
SHARED_FN vec3 sample_cosine_hemisphere(vec3 n, vec2 u) { return direction_about(n, sqrt(max(1.0f - u.x, 0.0f)), u.y); }

// Uniform over the cap of directions within an angle of `axis` whose 1 - cosine is `open`. The sine comes from 1 - cosine:
// the cosine itself has but 180 values within the sun's disc.
SHARED_FN vec3 sample_cap(vec3 axis, float open, vec2 u) {
  float down = open * u.x;
  return direction_turned(axis, 1.0f - down, sqrt(max(down * (2.0f - down), 0.0f)), u.y);
}

// Normal of a facet of a rough surface whose slopes are normal with the variance sigma2 along each axis (Box and Muller 1958).
SHARED_FN vec3 sample_facet(vec3 up, float sigma2, vec2 u) {
  float slope = sqrt(-2.0f * sigma2 * log(max(1.0f - u.x, 1.0e-7f)));
  float phi = 2.0f * kPi * u.y;
  vec3 t = tangent_of(up);
  vec3 b = cross(up, t);
  return normalize(up - slope * (t * cos(phi) + b * sin(phi)));
}

SHARED_END
#endif
