// Wind-roughened water: slope statistics of Cox and Munk 1954, isotropic; reflection of sun and sky as in Bruneton,
// Neyret and Holzschuch 2010. Angles from the geodetic vertical.
#ifndef NEPHO_COMMON_WATER_H
#define NEPHO_COMMON_WATER_H
#include "common/shared.h"
SHARED_BEGIN

// Mean square slope (both axes together) at a wind of `wind_mps` 12.5 m above the sea: 0.003 + 0.00512 W.
SHARED_FN float water_slope_variance(float wind_mps) { return 0.003f + 0.00512f * wind_mps; }

// Unpolarised Fresnel reflectance from air into sea water (n = 1.34), cos_i = cosine of the angle of incidence.
SHARED_FN float fresnel_water(float cos_i) {
  const float n = 1.34f;
  float c = clamp(cos_i, 0.0f, 1.0f);
  float g = sqrt(n * n - 1.0f + c * c);
  float a = (g - c) / (g + c);
  float b = (c * (g + c) - 1.0f) / (c * (g - c) + 1.0f);
  return 0.5f * a * a * (1.0f + b * b);
}

// Mean Fresnel reflectance of a rough sea seen at zenith cosine cos_v (Bruneton et al. 2010, eq. 18; sigma2 = one-axis
// slope variance).
SHARED_FN float fresnel_rough(float cos_v, float sigma2) {
  float sigma = sqrt(sigma2);
  return 0.02f + 0.98f * pow(1.0f - clamp(cos_v, 0.0f, 1.0f), 5.0f * exp(-2.69f * sigma)) / (1.0f + 22.7f * sigma * sqrt(sigma));
}

// Smith's Lambda of a Gaussian surface, fitted by Walter et al. 2007.
SHARED_FN float smith_lambda(float cos_theta, float sigma2) {
  float c = clamp(cos_theta, 1.0e-4f, 1.0f);
  float nu = c / (sqrt(2.0f * sigma2) * sqrt(max(1.0f - c * c, 1.0e-8f)));
  if (nu > 1.6f) return 0.0f;
  return (1.0f - 1.259f * nu + 0.396f * nu * nu) / (3.535f * nu + 2.181f * nu * nu);
}

// Sun glint: reflected radiance per irradiance on a plane facing the sun, 1/sr:
//   F p(slope) / (4 cos_v cos^4 beta), p Gaussian with one-axis variance sigma2, shadowing 1 / (1 + L(v) + L(s));
// cos_v enters as the projected area of the visible facets, (1 + L(v)) cos_v, which stays finite at the horizon.
// `up`, `to_eye`, `to_sun` unit.
SHARED_FN float sun_glint_per_sr(vec3 up, vec3 to_eye, vec3 to_sun, float mean_square_slope) {
  float cos_v = dot(up, to_eye);
  float cos_s = dot(up, to_sun);
  if (cos_s <= 0.0f) return 0.0f;
  cos_v = max(cos_v, 1.0e-3f);
  float sigma2 = 0.5f * mean_square_slope;
  vec3 half_vector = normalize(to_eye + to_sun);
  float cos_beta = dot(up, half_vector);
  if (cos_beta <= 0.05f) return 0.0f;
  float c2 = cos_beta * cos_beta;
  float tan2 = (1.0f - c2) / c2;
  float p = exp(-0.5f * tan2 / sigma2) / (2.0f * kPi * sigma2);
  float visible = 1.0f / (1.0f + smith_lambda(cos_v, sigma2) + smith_lambda(cos_s, sigma2));
  return fresnel_water(dot(to_eye, half_vector)) * p * visible / (4.0f * cos_v * c2 * c2);
}

// Diffuse reflectance of the water body under the surface, clear open ocean at 680, 550, 440 nm (order of Morel and
// Maritorena 2001 for 0.1 mg/m3 chlorophyll).
SHARED_FN vec3 water_body_albedo() { return vec3(0.0008f, 0.0065f, 0.028f); }

SHARED_END
#endif
