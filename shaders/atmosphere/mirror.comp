#version 460
#extension GL_GOOGLE_include_directive : require
// The sky over the sea, for all suns: what water mirrors. Slices: gas and aerosol, single scattering without their phase
// functions; multiple scattering.
#define ATMOSPHERE_BINDING 0
#define AIR_PATH_NODES 12
#include "atmosphere/atmosphere_light.glsl"
layout(local_size_x = 32, local_size_y = 2) in;
layout(set = 0, binding = 3, rgba32f) uniform writeonly image3D out_mirror;

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (at.x >= kAirNu * kAirMuS || at.y >= kMirrorMu) return;
  AtmosphereUniform air = atmosphere.air;
  float mu = sky_mu_from_unit(air, 0.0, unit_from_texel(at.y, kMirrorMu));
  float mu_s = mu_s_from_unit(air, unit_from_texel(at.x % kAirMuS, kAirMuS));
  // Not clamped to what mu and mu_s allow: the formulas continue smoothly beyond, as interpolation wants.
  float nu = nu_from_unit(unit_from_texel(at.x / kAirMuS, kAirNu));
  float length_m = distance_to_top(air, 0.0, mu);
  for (int part = 0; part < 2; ++part) {
    ScatteredLight light = scatter_along(0.0, mu, mu_s, nu, length_m, length_m, 1.0 - float(part), float(part));
    if (part == 0) {
      imageStore(out_mirror, ivec3(at, 0), vec4(light.smooth_part, 0));
      imageStore(out_mirror, ivec3(at, 1), vec4(light.mie, 0));
    } else {
      imageStore(out_mirror, ivec3(at, 2), vec4(light.smooth_part, 0));
    }
  }
}
