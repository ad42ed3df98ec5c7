#version 460
#extension GL_GOOGLE_include_directive : require
// Fills the air volume (air_volume_shared.h): one group per direction and light, one invocation per slice. Each integrates its slice
// with two nodes, with the columns of those before it; then light is summed from slice to slice.
#include "common/frame.h"
#include "atmosphere/air_volume_shared.h"
#define ATMOSPHERE_BINDING 0
#include "atmosphere/atmosphere_light.glsl"
layout(local_size_x = kAirSlices) in;
layout(scalar, set = 0, binding = 3) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(scalar, set = 0, binding = 4) uniform VolumeBlock { AirVolumeData data; } air_volume;
layout(set = 0, binding = 5, rgba32f) uniform writeonly image3D out_volume;

shared vec3 columns_of[kAirSlices];
shared vec3 gas_of[kAirSlices], aerosol_of[kAirSlices], multiple_of[kAirSlices];

// Gauss-Legendre with two nodes, and integrals of the line through them from the start to each node.
const vec2 kNodes = vec2(0.211324865, 0.788675135);
const mat2 kUpTo = mat2(0.25, 0.538675135, -0.038675135, 0.25);  // columns: of the first, the second node's density

AirNode node_at(AirVolumeData volume, AirVolumeLight light, float mu, float nu, float t) {
  AtmosphereUniform air = atmosphere.air;
  AirNode node;
  float h = air_height(air, volume.h, mu, t), r = air.radius_m + volume.h, inv_r = 1.0 / (air.radius_m + h);
  node.h = clamp(h, 0.0, air.top_m);
  node.mu = clamp((r * mu + t) * inv_r, -1.0, 1.0);
  node.mu_s = clamp((r * light.mu_s + t * nu) * inv_r, -1.0, 1.0);
  return node;
}

void main() {
  AirVolumeData volume = air_volume.data;
  AtmosphereUniform air = atmosphere.air;
  FrameConstants f = frame.frame_data;
  ivec3 group = ivec3(gl_WorkGroupID);
  int slice = int(gl_LocalInvocationIndex), light = group.z;
  AirVolumeLight from = volume.lights[light];
  bool down = group.y >= kAirSkyRows;
  int row = down ? group.y - kAirSkyRows : group.y;
  ivec2 seen = ivec2(group.x, down ? -1 - row : row);
  if (any(lessThan(seen, from.window.xy)) || any(greaterThan(seen, from.window.zw))) return;  // the whole group

  vec3 local = air_place_direction(volume, unit_from_texel(group.x, kAirAzimuths), unit_from_texel(row, down ? kAirGroundRows : kAirSkyRows), down);
  float mu = local.z, h = volume.h;
  vec3 scaled = local.x * from.forward + local.y * from.side + mu * volume.up;
  vec3 dir = normalize(vec3(scaled.x, scaled.y, scaled.z / f.planet.a_over_b));
  float nu = clamp(dot(dir, light == 0 ? f.sun_dir : f.moon_dir), -1.0, 1.0);
  float end_m = air_end(air, h, mu, down);
  float to_m = air_slice_distance(end_m, unit_from_texel(slice, kAirSlices));
  float from_m = slice == 0 ? 0.0 : air_slice_distance(end_m, unit_from_texel(slice - 1, kAirSlices));
  float length_m = to_m - from_m;

  vec3 density[2];
  for (int i = 0; i < 2; ++i) density[i] = densities(air, air_height(air, h, mu, from_m + kNodes[i] * length_m));
  vec3 column = 0.5 * length_m * (density[0] + density[1]);
  columns_of[slice] = column;
  barrier();
  vec3 before = vec3(0.0);
  for (int i = 0; i < slice; ++i) before += columns_of[i];

  // Light that comes from all around changes little within a slice: one look for both nodes.
  AirNode middle = node_at(volume, from, mu, nu, from_m + 0.5 * length_m);
  vec4 source = sampled_source(air, source_tex, middle, nu);
  float again = night_fade(air, middle.mu_s);
  vec3 columns[2], whole[2];
  float sunlit[2];
  for (int i = 0; i < 2; ++i) {
    AirNode node = node_at(volume, from, mu, nu, from_m + kNodes[i] * length_m);
    columns[i] = before + length_m * (kUpTo[0][i] * density[0] + kUpTo[1][i] * density[1]);
    whole[i] = columns[i] + sampled_columns_to_top(air, node.h, node.mu_s);
    sunlit[i] = sun_visibility(air, node.h, node.mu_s);
  }
  vec3 gas = vec3(0.0), aerosol = vec3(0.0), multiple = vec3(0.0);
  for (int g = 0; g < kSpectralGroups; ++g) {
    SpectralGroup of = atmosphere.spectrum[g];
    vec3 sun[2], eye[2];
    for (int i = 0; i < 2; ++i) {
      sun[i] = sunlit[i] * exp(-optical_depth(of, whole[i]));
      eye[i] = exp(-optical_depth(of, columns[i]));
    }
    vec3 light_in = 0.5 * length_m * of.solar_irradiance;
    vec3 by_gas = light_in * of.rayleigh_scattering_per_m, by_aerosol = light_in * of.mie_scattering_per_m;
    gas += of.rgb * (by_gas * (density[0].x * sun[0] + density[1].x * sun[1]));
    aerosol += of.rgb * (by_aerosol * (density[0].y * sun[0] + density[1].y * sun[1]));
    multiple += of.rgb * ((by_gas * (density[0].x * eye[0] + density[1].x * eye[1]) + by_aerosol * (density[0].y * eye[0] + density[1].y * eye[1])) *
                          again * exp(of.basis * source));
  }
  gas_of[slice] = gas;
  aerosol_of[slice] = aerosol;
  multiple_of[slice] = multiple;
  barrier();
  gas = aerosol = multiple = vec3(0.0);
  for (int i = 0; i <= slice; ++i) {
    gas += gas_of[i];
    aerosol += aerosol_of[i];
    multiple += multiple_of[i];
  }

  vec3 depth = -log(max(transmittance_of(before + column), vec3(kLeastThrough)));
  vec2 even = max(even_columns(air, h, air_height(air, h, mu, to_m), to_m), vec2(1.0e-30));
  vec3 even_depth = even.x * volume.gas_per_m + even.y * volume.aerosol_per_m;
  vec3 share = open_share(depth, exp(-depth));
  vec3 factor = atmosphere.air.luminance_factor * (light == 0 ? vec3(f.sun_distance_factor) : f.moon_share) / share;
  vec3 stored_depth = depth / even_depth;
  ivec3 to = ivec3(light * kAirAzimuths + group.x, group.y, slice);
  imageStore(out_volume, to, vec4(gas * (phase_rayleigh(nu) / even.x) * factor, stored_depth.r));
  imageStore(out_volume, to + ivec3(0, kAirRows, 0), vec4(aerosol / even.y * factor, stored_depth.g));
  imageStore(out_volume, to + ivec3(0, 2 * kAirRows, 0), vec4(multiple / even_depth * factor, stored_depth.b));
}
