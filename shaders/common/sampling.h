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
// as what the cosine lacks of 1: exact in narrow lobes, and no small g is divided by.
SHARED_FN float sample_hg_cosine(float g, float u) {
  float t = 1.0f + g - 2.0f * g * u, w = (1.0f - g) * u / t;
  return clamp(1.0f - 2.0f * (1.0f - g + g * w) * w, -1.0f, 1.0f);
}

// Share of Draine's lobe that is nearer to straight on than Henyey-Greenstein's share v of the same g, in closed form: the
// integral of (1 + alpha c(v)^2) / N over v, N its value at 1, where the cosine is c = 1 - 2 (1-g)^2 w (1 + g w), w = v / t,
// t = 1 + g - 2 g v. No term is a difference of near ones, and no g is divided by.
SHARED_FN float draine_share(float g, float alpha, float v) {
  float t = 1.0f + g - 2.0f * g * v, w = v / t, narrow = (1.0f - g) * (1.0f - g);
  float squares = v - 2.0f * narrow * v * w + narrow * narrow * w * w * w * (1.0f + g + 3.0f * t) / 3.0f;
  return (v + alpha * squares) / (1.0f + alpha * (1.0f + 2.0f * g * g) / 3.0f);
}

// Cosine of the scattering angle of Draine's lobe, by inversion (u = 0 is straight on): Newton's steps for the share v of
// Henyey-Greenstein's lobe that has the same cosine. The share bends one way up to 90 degrees and the other way beyond: begun at the
// end of the half that holds the answer, steps never pass it. alpha = 0 is sample_hg_cosine().
SHARED_CONST int kDraineSteps = 12;
SHARED_FN float sample_draine_cosine(float g, float alpha, float u) {
  float v = u;
  if (alpha > 0.0f) {
    float norm = 1.0f + alpha * (1.0f + 2.0f * g * g) / 3.0f;
    float w = 1.0f / ((1.0f - g) * (1.0f - g + sqrt(1.0f + g * g)));  // of 90 degrees, as in draine_share()
    v = u < draine_share(g, alpha, w * (1.0f + g) / (1.0f + 2.0f * g * w)) ? 0.0f : 1.0f;
    for (int i = 0; i < kDraineSteps; ++i) {
      float c = sample_hg_cosine(g, v);
      v = clamp(v - (draine_share(g, alpha, v) - u) * norm / (1.0f + alpha * c * c), 0.0f, 1.0f);
    }
  }
  return sample_hg_cosine(g, v);
}

// The same of two lobes: u decides the lobe, and what is left of it the angle.
SHARED_FN float sample_lobes_cosine(PhaseLobes p, float u) {
  bool second = u < p.weight;
  float rest = second ? u / p.weight : (u - p.weight) / (1.0f - p.weight);
  return sample_draine_cosine(second ? p.g1 : p.g0, second ? p.alpha1 : p.alpha0, min(rest, 0.99999994f));
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
