// Haze and fog: particles whose density depends on the height alone, over a sphere of radius R (scaled space, common/planet.h).
// Density 1 from `bottom` to `base`, exp(-(h - base) / H) from `base` to `top`, 0 elsewhere. Derivations: docs/light.md, 'Haze'.
#ifndef NEPHO_HAZE_SHARED_H
#define NEPHO_HAZE_SHARED_H
#include "common/shared.h"
SHARED_BEGIN

SHARED_CONST uint kMaxHazeLayers = 4u;
// An exponential layer without a top ends so many scale heights above its base: 8e-7 of its matter is higher.
SHARED_CONST float kHazeReach = 14.0f;

// Heights in scaled space.
struct HazeLayerData {
  float extinction_per_m;  // at density 1, per true metre
  float bottom_m, base_m, top_m;
  float scale_height_m;
  float albedo;            // single-scattering albedo
  float g;                 // of Henyey-Greenstein
  float pad0;
};

struct HazeData {
  HazeLayerData layers[kMaxHazeLayers];
  float top_m;             // of the highest layer: nothing above
  float bulk_m;            // below it lies most of the haze: where rays take their steps
  float radius_m;          // R
  float pad0;
};

// exp(x^2) erfc(x) for x >= 0, relative error 1.2e-7 (Numerical Recipes, 3rd edition, 6.2.2).
SHARED_FN float erfc_scaled(float x) {
  float t = 1.0f / (1.0f + 0.5f * x);
  return t * exp(-1.26551223f +
                 t * (1.00002368f +
                      t * (0.37409196f +
                           t * (0.09678418f +
                                t * (-0.18628806f +
                                     t * (0.27886807f + t * (-1.13520398f + t * (1.48851587f + t * (-0.82215223f + t * 0.17087277f)))))))));
}

// Integral of exp(-b t - a t^2) over 0..length, a, b >= 0: Gauss-Legendre where the exponent changes by less than 1 (the closed form
// would be a difference of near numbers), else by error functions.
SHARED_FN float integral_of_exp(float b, float a, float length_m) {
  float fall = length_m * (b + a * length_m);
  float t0 = 0.11270167f * length_m, t1 = 0.5f * length_m, t2 = 0.88729833f * length_m;
  float sum = (5.0f * (exp(-t0 * (b + a * t0)) + exp(-t2 * (b + a * t2))) + 8.0f * exp(-t1 * (b + a * t1))) * (length_m / 18.0f);
  float root = sqrt(max(a, 1.0e-24f));
  float x = 0.5f * b / root;
  float closed = 0.88622693f / root * (erfc_scaled(x) - exp(-fall) * erfc_scaled(x + root * length_m));
  return fall < 1.0f ? sum : closed;
}

// Height at a distance t along a ray from height h with zenith cosine mu; may be negative.
SHARED_FN float haze_height_along(float radius, float h, float mu, float t) {
  float rho2 = h * (2.0f * radius + h) + t * (2.0f * (radius + h) * mu + t);
  return rho2 / (radius + sqrt(max(radius * radius + rho2, 0.0f)));
}

// Distance along a ray that rises from height h with zenith cosine mu >= 0 to another height; 0 for lower ones.
SHARED_FN float haze_distance_up(float radius, float h, float mu, float to_m) {
  float r_mu = (radius + h) * mu;
  float gap = max(to_m - h, 0.0f) * (2.0f * radius + to_m + h);
  return gap > 0.0f ? gap / (r_mu + sqrt(r_mu * r_mu + gap)) : 0.0f;
}

// Column (density integrated, m) of the first length_m of a ray that rises from height h with zenith cosine mu >= 0. Heights along it
// are h + mu t + (1 - mu^2) t^2 / (2 r) as far up as the layer reaches, so that the exponential part is a Gaussian integral.
SHARED_FN float haze_column_up(HazeLayerData layer, float radius, float h, float mu, float length_m) {
  float to_bottom = haze_distance_up(radius, h, mu, layer.bottom_m);
  float to_base = haze_distance_up(radius, h, mu, layer.base_m);
  float end = min(length_m, haze_distance_up(radius, h, mu, layer.top_m));
  float even = max(min(end, to_base) - to_bottom, 0.0f);
  float start = max(to_base, to_bottom);
  float start_h = haze_height_along(radius, h, mu, start);
  float r = radius + start_h;
  float start_mu = clamp(((radius + h) * mu + start) / r, 0.0f, 1.0f);
  float inv_h = 1.0f / layer.scale_height_m;
  float thin = exp(-max(start_h - layer.base_m, 0.0f) * inv_h) *
               integral_of_exp(start_mu * inv_h, 0.5f * (1.0f - start_mu * start_mu) / r * inv_h, max(end - start, 0.0f));
  return even + (end > start ? thin : 0.0f);
}

// Column of any straight path of length_m from height h with zenith cosine mu at its start: both sides of its lowest point.
SHARED_FN float haze_column(HazeLayerData layer, float radius, float h, float mu, float length_m) {
  float down = clamp(-(radius + h) * mu, 0.0f, length_m);
  float low_h = haze_height_along(radius, h, mu, down);
  float low_mu = clamp(((radius + h) * mu + down) / (radius + low_h), -1.0f, 1.0f);
  float column = haze_column_up(layer, radius, low_h, max(low_mu, 0.0f), length_m - down);
  return column + haze_column_up(layer, radius, low_h, max(-low_mu, 0.0f), down);
}

SHARED_FN float haze_density(HazeLayerData layer, float h) {
  bool inside = h >= layer.bottom_m && h < layer.top_m;
  return inside ? exp(-max(h - layer.base_m, 0.0f) / layer.scale_height_m) : 0.0f;
}

// Column straight up from a height, over flat ground.
SHARED_FN float haze_column_above(HazeLayerData layer, float h) {
  float from = max(h, layer.bottom_m);
  float even = max(min(layer.base_m, layer.top_m) - from, 0.0f);
  float lower = max(max(from, layer.base_m) - layer.base_m, 0.0f), upper = max(layer.top_m - layer.base_m, 0.0f);
  return even + max(exp(-lower / layer.scale_height_m) - exp(-upper / layer.scale_height_m), 0.0f) * layer.scale_height_m;
}

// Light that haze has scattered, Eddington's two streams through an even slab without absorption over black ground. Optical depths
// are those of the isotropic medium that diffuses as much, (1 - albedo g) times the true ones (similarity): `above` the point, `total`.
struct HazeDiffuse {
  float fluence;  // of scattered light at the point, per irradiance
  float ground;   // flux of scattered light on the ground, per irradiance
};

// Of a beam with zenith cosine mu0 > 0, per irradiance of a plane that faces it.
SHARED_FN HazeDiffuse haze_diffuse_beam(float above, float total, float mu0) {
  float at = exp(-above / mu0), below = exp(-total / mu0);
  float net = mu0 * ((2.0f + 3.0f * mu0) + (2.0f - 3.0f * mu0) * below) / (4.0f + 3.0f * total);
  HazeDiffuse d;
  d.ground = max(net - mu0 * below, 0.0f);
  d.fluence = max(2.0f * d.ground + 3.0f * net * (total - above) - 3.0f * mu0 * mu0 * (at - below), 0.0f);
  return d;
}

// Fluence of an even sky of unit horizontal irradiance above (depth: optical depth on the far side of the point); the flux on the ground
// is haze_sky_flux().
SHARED_FN float haze_sky_flux(float total) { return 4.0f / (4.0f + 3.0f * total); }
SHARED_FN float haze_sky_fluence(float beyond, float total) { return haze_sky_flux(total) * (2.0f + 3.0f * beyond); }

// Share of that light that absorption leaves: photons that stay get another chance to be absorbed at every collision. `albedo` is that of
// the isotropic medium.
SHARED_FN float haze_survival(float albedo, float total) {
  float escape = 1.0f / (1.0f + 0.75f * total);
  return albedo * escape / (1.0f - albedo * (1.0f - escape));
}
SHARED_FN float haze_isotropic_albedo(float albedo, float g) { return albedo * (1.0f - g) / max(1.0f - albedo * g, 1.0e-6f); }

SHARED_END
#endif
