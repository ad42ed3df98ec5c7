#version 460
#extension GL_GOOGLE_include_directive : require
// The tables that frames look up: light from the sky along rays that reach space, single scattering by gas and aerosol
// without their phase functions, multiple scattering, and under that the source function itself.
#include "atmosphere/atmosphere_shared.h"
layout(local_size_x = 32, local_size_y = 2) in;
layout(scalar, set = 0, binding = 0) uniform AtmosphereBlock { AtmosphereUniform atmosphere_data; } atmosphere;
layout(set = 0, binding = 1) uniform sampler2D transmittance_tex;
layout(set = 0, binding = 2) uniform sampler3D source_tex;
layout(set = 0, binding = 3, rgba16f) uniform writeonly image3D out_rayleigh;
layout(set = 0, binding = 4, rgba16f) uniform writeonly image3D out_mie;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image3D out_multiple;
layout(push_constant) uniform Push { int order; int first_slice; } push;  // order: the highest

#define AIR_PATH_NODES 12
#define SOURCE_TEX source_tex
#define SOURCE_ROW0 0.0
#define SOURCE_ROWS float(kSourceMu)
#define SOURCE_SCALE 1.0
#include "atmosphere/air_path.glsl"

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID) + ivec3(0, 0, push.first_slice);
  if (at.x >= kAirNu * kAirMuS || at.y >= kMultipleRows || at.z >= kAirR) return;
  AtmosphereUniform air = atmosphere.atmosphere_data;
  bool multiple = push.order > 1;
  if (at.y >= kSkyMu) {
    vec4 source = multiple ? texelFetch(source_tex, at - ivec3(0, kSkyMu, 0), 0) : vec4(0);
    imageStore(out_multiple, at, source * kTableScale);
    return;
  }
  float h = height_from_unit(air, unit_from_texel(at.z, kAirR));
  float mu = sky_mu_from_unit(air, h, unit_from_texel(at.y, kSkyMu));
  float mu_s = mu_s_from_unit(air, unit_from_texel(at.x % kAirMuS, kAirMuS));
  // Not clamped to what mu and mu_s allow: the formulas continue smoothly beyond, as interpolation wants.
  float nu = nu_from_unit(unit_from_texel(at.x / kAirMuS, kAirNu));
  ScatteredLight light = scatter_along(air, h, mu, mu_s, nu, distance_to_top(air, h, mu), true, multiple);
  imageStore(out_rayleigh, at, vec4(light.rayleigh * kTableScale, 0));
  imageStore(out_mie, at, vec4(light.mie * kTableScale, 0));
  imageStore(out_multiple, at, vec4(light.multiple * kTableScale, 0));
}
