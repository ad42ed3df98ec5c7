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

// The unit vector at cosine cos_theta from the unit vector axis, turned about it by 2 pi u.
SHARED_FN vec3 direction_about(vec3 axis, float cos_theta, float u) {
  float sin_theta = sqrt(max(1.0f - cos_theta * cos_theta, 0.0f));
  float phi = 2.0f * kPi * u;
  vec3 t = tangent_of(axis);
  vec3 b = cross(axis, t);
  return normalize(axis * cos_theta + (t * cos(phi) + b * sin(phi)) * sin_theta);
}

// Cosine of the scattering angle of Henyey-Greenstein by inversion; g near 0 by its limit 1 - 2 u.
SHARED_FN float sample_hg_cosine(float g, float u) {
  if (abs(g) < 1.0e-3f) return clamp(1.0f - 2.0f * u + 1.5f * g * (1.0f - (1.0f - 2.0f * u) * (1.0f - 2.0f * u)), -1.0f, 1.0f);
  float s = (1.0f - g * g) / (1.0f + g - 2.0f * g * u);
  return clamp((1.0f + g * g - s * s) / (2.0f * g), -1.0f, 1.0f);
}

// The same of two lobes: u decides the lobe, and what is left of it the angle.
SHARED_FN float sample_dual_hg_cosine(float g0, float g1, float w, float u) {
  if (u < w) return sample_hg_cosine(g1, min(u / w, 0.99999994f));
  return sample_hg_cosine(g0, min((u - w) / (1.0f - w), 0.99999994f));
}

// Cosine-weighted over the hemisphere about n: density cos / pi.
SHARED_FN vec3 sample_cosine_hemisphere(vec3 n, vec2 u) { return direction_about(n, sqrt(max(1.0f - u.x, 0.0f)), u.y); }

// Uniform over the cap of directions within an angle of `axis` whose 1 - cosine is `open`.
SHARED_FN vec3 sample_cap(vec3 axis, float open, vec2 u) { return direction_about(axis, 1.0f - open * u.x, u.y); }

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
