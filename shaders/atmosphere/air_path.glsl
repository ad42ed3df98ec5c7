// Light scattered into a path through the air: direct quadrature, with no difference of two lookups anywhere.
// Needs before the include: `transmittance_tex` declared, AIR_PATH_NODES (8 or 12), and SOURCE_TEX, SOURCE_ROW0,
// SOURCE_ROWS, SOURCE_SCALE (the texture of the source function, its first row, its height in rows, its unit).
#include "atmosphere/atmosphere_shared.h"
#include "common/phase.h"

vec3 sampled_optical_depth_to_top(AtmosphereUniform air, float h, float mu) {
  vec2 uv = vec2(texel_coord(unit_from_sky_mu(air, h, mu), kTransmittanceMu),
                 texel_coord(unit_from_height(air, h), kTransmittanceR));
  return textureLod(transmittance_tex, uv, 0.0).rgb;
}

// Share of sunlight that reaches height h within the air.
vec3 sunlight_within(AtmosphereUniform air, float h, float mu_s) {
  return sun_visibility(air, h, mu_s) * exp(-sampled_optical_depth_to_top(air, h, mu_s));
}

// Two reads on either side of the view-sun angle. `x` is that angle's unit, `v` the row, `w` the slice.
vec3 sample_4d(sampler3D tex, float unit_nu, float unit_mu_s, float v, float w) {
  float x = unit_nu * float(kAirNu - 1);
  float i = min(floor(x), float(kAirNu - 2));
  float u = texel_coord(unit_mu_s, kAirMuS);
  vec3 a = textureLod(tex, vec3((i + u) / float(kAirNu), v, w), 0.0).rgb;
  vec3 b = textureLod(tex, vec3((i + 1.0 + u) / float(kAirNu), v, w), 0.0).rgb;
  return mix(a, b, x - i);
}

// Source function of multiply scattered light: radiance per unit of scattering coefficient, W m^-2 sr^-1 nm^-1.
vec3 sampled_source(AtmosphereUniform air, float h, float mu, float mu_s, float nu) {
  float v = (SOURCE_ROW0 + 0.5 + (0.5 + 0.5 * mu) * float(kSourceMu - 1)) / SOURCE_ROWS;
  return sample_4d(SOURCE_TEX, unit_from_nu(nu), unit_from_mu_s(air, mu_s), v, texel_coord(unit_from_height(air, h), kAirR)) *
         (1.0 / SOURCE_SCALE);
}

struct ScatteredLight {
  vec3 rayleigh;       // single scattering without the phase function, W m^-2 nm^-1
  vec3 mie;            // the same
  vec3 multiple;       // W m^-2 sr^-1 nm^-1
  vec3 optical_depth;  // of the path
};

// Over `length_m` from height h. The transmittance to a node is a quotient of two lookups to the top, taken upwards on
// either side of the lowest point; its error multiplies the light and does not grow as the path shrinks.
ScatteredLight scatter_along(AtmosphereUniform air, float h, float mu, float mu_s, float nu, float length_m, bool sun, bool source) {
  ScatteredLight light = ScatteredLight(vec3(0), vec3(0), vec3(0), vec3(0));
  float r = air.radius_m + h;
  float low_m = clamp(-r * mu, 0.0, length_m);
  // Up the reversed ray from a node: depth(node) - depth(start); up the ray: depth(low) - depth(node), plus what led down.
  vec3 depth_start = sampled_optical_depth_to_top(air, h, abs(mu));
  vec3 depth_low = depth_start;
  if (low_m > 0.0) depth_low = sampled_optical_depth_to_top(air, height_along(air, h, mu, low_m), 0.0);
  for (int i = 0; i < 2 * AIR_PATH_NODES; ++i) {
    int part = i >= AIR_PATH_NODES ? 1 : 0;
    PathPart p = path_part(air, h, mu, length_m, part);
    if (p.length_m <= 0.0) continue;
    int k = i - part * AIR_PATH_NODES;
#if AIR_PATH_NODES == 8
    vec2 node = path_node(p, kGauss8X[k], kGauss8W[k]);
#else
    vec2 node = path_node(p, kGauss12X[k], kGauss12W[k]);
#endif
    float t = node.x;
    float ht = height_along(air, h, mu, t);
    float rt = air.radius_m + ht;
    float mu_t = clamp((r * mu + t) / rt, -1.0, 1.0);
    float mu_s_t = clamp((r * mu_s + t * nu) / rt, -1.0, 1.0);
    vec3 depth_node = sampled_optical_depth_to_top(air, ht, abs(mu_t));
    vec3 depth = part == 0 ? depth_node - depth_start
                           : (low_m > 0.0 ? 2.0 * depth_low - depth_start : depth_start) - depth_node;
    vec3 seen = node.y * exp(-max(depth, vec3(0)));
    vec3 d = densities(air, ht);
    light.optical_depth += node.y * extinction_per_m(air, d);
    if (sun) {
      vec3 lit = seen * sunlight_within(air, ht, mu_s_t);
      light.rayleigh += d.x * lit;
      light.mie += d.y * lit;
    }
    if (source) {
      light.multiple += seen * (d.x * air.rayleigh_scattering_per_m + d.y * air.mie_scattering_per_m) *
                        sampled_source(air, ht, mu_t, mu_s_t, nu);
    }
  }
  light.rayleigh *= air.rayleigh_scattering_per_m * air.solar_irradiance;
  light.mie *= air.mie_scattering_per_m * air.solar_irradiance;
  // Long paths near the horizon are beyond these few nodes; there the table is the better witness.
  if (length_m > 30000.0) {
    float ht = height_along(air, h, mu, length_m);
    float mu_t = clamp((r * mu + length_m) / (air.radius_m + ht), -1.0, 1.0);
    vec3 depth_end = sampled_optical_depth_to_top(air, ht, abs(mu_t));
    vec3 depth = mu_t < 0.0 ? depth_end - depth_start
                            : (low_m > 0.0 ? 2.0 * depth_low - depth_start : depth_start) - depth_end;
    light.optical_depth = max(depth, vec3(0));
  }
  return light;
}
