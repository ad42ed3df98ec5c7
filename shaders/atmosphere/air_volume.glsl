// Aerial perspective and light at points by a few texture reads, for frames that have an air volume (air_volume_shared.h).
//
//   #define AIR_VOLUME_BINDING 60        // takes this binding and the two after it; AirVolume::bind() fills them
//   #include "atmosphere/air_volume.glsl"   // after atmosphere/atmosphere_lookup.glsl
#ifndef NEPHO_AIR_VOLUME_GLSL
#define NEPHO_AIR_VOLUME_GLSL
#include "atmosphere/air_volume_shared.h"
layout(scalar, set = 0, binding = AIR_VOLUME_BINDING) uniform AirVolumeBlock { AirVolumeData data; } air_volume;
layout(set = 0, binding = AIR_VOLUME_BINDING + 1) uniform sampler3D air_volume_tex;
layout(set = 0, binding = AIR_VOLUME_BINDING + 2) uniform sampler2D light_table_tex;

// A ray through the volume of one light.
struct VolumeRay {
  vec2 at;         // texture coordinates of its direction, in the part of gas
  float mu;
  float end_m;     // scaled
  float stretch;   // scaled metres per true metre
  float aerosol_phase;
};

VolumeRay volume_ray(vec3 dir, vec3 light_dir, int light) {
  AirVolumeLight of = air_volume.data.lights[light];
  vec3 scaled = scaled_from_cam(frame.frame_data.planet, dir);
  AirPlace place = air_place(air_volume.data, dot(scaled, of.forward), dot(scaled, of.side), dot(scaled, air_volume.data.up));
  VolumeRay ray;
  float row = place.down ? float(kAirSkyRows) + 0.5 + place.row * float(kAirGroundRows - 1) : 0.5 + place.row * float(kAirSkyRows - 1);
  ray.at = vec2((float(light * kAirAzimuths) + 0.5 + place.azimuth * float(kAirAzimuths - 1)) / float(2 * kAirAzimuths), row / float(kAirParts * kAirRows));
  ray.mu = place.mu;
  ray.end_m = air_end(atmosphere.air, air_volume.data.h, place.mu, place.down);
  ray.stretch = length(scaled);
  ray.aerosol_phase = phase_aerosol(atmosphere.air, clamp(dot(dir, light_dir), -1.0, 1.0));
  return ray;
}

vec4 volume_read(VolumeRay ray, float slice, int part) {
  return textureLod(air_volume_tex, vec3(ray.at.x, ray.at.y + float(part) / float(kAirParts), (0.5 + slice * float(kAirSlices - 1)) / float(kAirSlices)), 0.0);
}

struct VolumeAir {
  vec3 single;     // luminance of light scattered once
  vec3 multiple;   // more often
  vec3 through;    // transmittance
};

// Of the air before the point at distance_m true metres along the ray.
VolumeAir volume_air(VolumeRay ray, float distance_m) {
  AtmosphereUniform air = atmosphere.air;
  float h = air_volume.data.h, length_m = min(distance_m * ray.stretch, ray.end_m);
  float slice = air_slice(ray.end_m, length_m);
  vec4 gas = volume_read(ray, slice, 0), aerosol = volume_read(ray, slice, 1), multiple = volume_read(ray, slice, 2);
  vec2 even = even_columns(air, h, air_height(air, h, ray.mu, length_m), length_m);
  vec3 even_depth = even.x * air_volume.data.gas_per_m + even.y * air_volume.data.aerosol_per_m;
  vec3 depth = even_depth * vec3(gas.a, aerosol.a, multiple.a);
  VolumeAir of;
  of.through = exp(-depth);
  vec3 share = open_share(depth, of.through);
  of.single = share * (gas.rgb * even.x + aerosol.rgb * (even.y * ray.aerosol_phase));
  of.multiple = share * multiple.rgb * even_depth;
  return of;
}

// aerial_perspective() of atmosphere_lookup.glsl, without shadow.
vec3 volume_aerial_perspective(FrameConstants f, vec3 dir, float distance_m, out vec3 transmittance) {
  vec3 luminance = vec3(0.0);
  for (int i = 0; i < count_lights(f, dir.x); ++i) {
    VolumeAir air = volume_air(volume_ray(dir, light_dir(f, i), i), distance_m);
    luminance += air.single + air.multiple;
    transmittance = air.through;
  }
  return luminance;
}

vec3 light_table(float row, float mu, int table, float mu_low, float mu_span) {
  float u = clamp((mu - mu_low) / mu_span, 0.0, 1.0);
  float v = (float(table * kLightHeights) + 0.5 + row * float(kLightHeights - 1)) / float(kLightTables * kLightHeights);
  return exp(textureLod(light_table_tex, vec2(texel_coord(u, kLightMu), v), 0.0).rgb);
}

// key_illuminance() of atmosphere_lookup.glsl.
vec3 tabled_key_illuminance(FrameConstants f, float height_m, float mu) {
  float row = light_row(air_volume.data, height_m);
  return f.key_illuminance * sun_visibility(atmosphere.air, max(height_m, 0.0), mu) *
         light_table(row, mu, 0, air_volume.data.mu_low.x, air_volume.data.mu_span.x);
}

// sky_illuminance() and moon_fill_illuminance() together.
vec3 tabled_sky_illuminance(FrameConstants f, float height_m, vec3 up) {
  float row = light_row(air_volume.data, height_m);
  vec3 sky = light_table(row, dot(up, f.sun_dir), 1, air_volume.data.mu_low.y, air_volume.data.mu_span.y);
  for (int i = 1; i < count_lights(f, up.x); ++i) {
    float mu = dot(up, f.moon_dir);
    sky += light_table(row, mu, 2, air_volume.data.mu_low.z, air_volume.data.mu_span.z);
    sky += max(mu, 0.0) * sun_visibility(atmosphere.air, max(height_m, 0.0), mu) *
           light_table(row, mu, 3, air_volume.data.mu_low.z, air_volume.data.mu_span.z);
  }
  return sky;
}
#endif
