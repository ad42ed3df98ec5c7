#version 460
#extension GL_GOOGLE_include_directive : require
// Integrates the sky seen from cameras within the air: single scattering by gas plus multiple scattering, and under it
// single scattering by aerosol without its phase function, and the transmittance to space.
#define ATMOSPHERE_BINDING 0
#include "atmosphere/atmosphere_light.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 3, scalar) readonly buffer SkyViewBlock { SkyView data[]; } sky_views;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2D out_sky_view;

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID);
  if (at.x >= kSkyAzimuths || at.y >= kSkyRows) return;
  SkyView view = sky_views.data[at.z];
  vec3 local = sky_view_direction(view, vec2(unit_from_texel(at.x, kSkyAzimuths), unit_from_texel(at.y, kSkyRows)));
  float mu = local.z;
  vec3 scaled = local.x * view.forward + local.y * view.side + mu * view.up;
  vec3 dir = normalize(vec3(scaled.x, scaled.y, scaled.z / view.a_over_b));
  float nu = clamp(dot(dir, view.light_dir), -1.0, 1.0);
  float length_m = distance_to_top(atmosphere.air, view.h, mu);
  ScatteredLight light = scatter_along(view.h, mu, view.mu_s, nu, length_m, length_m, phase_rayleigh(nu), 1.0);
  ivec2 to = ivec2((at.z % kSkyViewsWide) * kSkyAzimuths + at.x, (at.z / kSkyViewsWide) * kSkyParts * kSkyRows + at.y);
  imageStore(out_sky_view, to, vec4(light.smooth_part, 0));
  imageStore(out_sky_view, to + ivec2(0, kSkyRows), vec4(light.mie, 0));
  imageStore(out_sky_view, to + ivec2(0, 2 * kSkyRows), vec4(transmittance_of(light.columns), 0));
}
