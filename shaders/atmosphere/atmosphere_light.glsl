// Light along paths through the air, over the tables of columns and of the source function.
//
//   #define ATMOSPHERE_BINDING 8      // takes this binding and the two after it
#ifndef NEPHO_ATMOSPHERE_LIGHT_GLSL
#define NEPHO_ATMOSPHERE_LIGHT_GLSL
#include "atmosphere/atmosphere_shared.h"

layout(scalar, set = 0, binding = ATMOSPHERE_BINDING) uniform AtmosphereBlock {
  AtmosphereUniform air;
  SpectralGroup spectrum[kMaxSpectralGroups];
} atmosphere;
layout(set = 0, binding = ATMOSPHERE_BINDING + 1) uniform sampler2D transmittance_tex;
layout(set = 0, binding = ATMOSPHERE_BINDING + 2) uniform sampler3D source_tex;

#ifndef AIR_PATH_NODES
#define AIR_PATH_NODES 8
#endif
#include "atmosphere/air_path.glsl"

// Light of the spectrum summed to three channels, for a sun at 1 au; multiply by luminance_factor.
struct ScatteredLight {
  vec3 smooth_part;  // gas with its phase function, and multiple scattering
  vec3 mie;          // single scattering by aerosol, without its phase function
  vec3 columns;      // of the path
};

// Over `length_m` from height h; sunlight reaches the first `sunlit_m` of it. `rayleigh_phase` multiplies single scattering by
// gas, `source_share` multiple scattering.
ScatteredLight scatter_along(float h, float mu, float mu_s, float nu, float length_m, float sunlit_m, float rayleigh_phase,
                             float source_share) {
  AtmosphereUniform air = atmosphere.air;
  ScatteredLight light = ScatteredLight(vec3(0), vec3(0), vec3(0));
  AirPath path = air_path(air, h, mu, mu_s, nu, length_m, sunlit_m);
  int count = node_count(path);
  for (int i = 0; i < count; ++i) {
    AirNode node = air_node(air, path, i);
    vec4 source = sampled_source(air, source_tex, node, nu);
    vec3 sum_columns = node.columns + node.columns_to_sun;
    float sunlit = node.weight_m * node.sunlit;
    for (int g = 0; g < kSpectralGroups; ++g) {
      SpectralGroup group = atmosphere.spectrum[g];
      vec3 sun = sunlit * group.solar_irradiance * exp(-optical_depth(group, sum_columns));
      vec3 gas = node.density.x * group.rayleigh_scattering_per_m;
      vec3 aerosol = node.density.y * group.mie_scattering_per_m;
      vec3 again = (node.weight_m * source_share * night_fade(air, node.mu_s)) * group.solar_irradiance * exp(group.basis * source - optical_depth(group, node.columns));
      light.smooth_part += group.rgb * (rayleigh_phase * gas * sun + (gas + aerosol) * again);
      light.mie += group.rgb * (aerosol * sun);
    }
    light.columns += node.weight_m * node.density;
  }
  light.columns = path_columns(air, path, light.columns);
  return light;
}

// Share of unscattered sunlight that passes, per channel; with one group, the transmittances of its wavelengths.
vec3 transmittance_of(vec3 columns) {
  vec3 share = vec3(0);
  for (int g = 0; g < kSpectralGroups; ++g) {
    SpectralGroup group = atmosphere.spectrum[g];
    share += group.sun_share * exp(-optical_depth(group, columns));
  }
  return clamp(share, vec3(0), vec3(1));
}
#endif
