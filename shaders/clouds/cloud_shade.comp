#version 460
#extension GL_GOOGLE_include_directive : require
// Lights the marched clouds: shares of the lights become premultiplied luminance with its aerial perspective. A shader of its own,
// because the march leaves no registers for the air's spectrum.
#include "common/frame.h"
#include "common/gamut.h"
layout(local_size_x = 16, local_size_y = 16) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1) uniform sampler2D light_tex;  // shares of key light, sky light, lit ground (1/sr); transmittance
layout(set = 0, binding = 2) uniform sampler2D near_tex;    // of the nearer of two depths: shares of the lights, opacity
layout(set = 0, binding = 3) uniform sampler2D depths_tex;  // the two, m; equal where there is one; kFarDepth_m without clouds
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2D out_radiance;
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2D out_near;  // luminance of what is at the nearer depth; its opacity
#define ATMOSPHERE_BINDING 8
#include "atmosphere/atmosphere_lookup.glsl"
#define AIR_VOLUME_BINDING 16
#include "atmosphere/air_volume.glsl"
#define PIXEL_LIST_BINDING 40
#define PIXEL_LIST_CONSTANT 1
#include "clouds/pixel_list.glsl"  // of an upscaled picture: the pixels of this frame
layout(constant_id = 2) const bool kVolume = false;  // the air and the lights are read from the air volume
layout(push_constant, scalar) uniform PushBlock {
  float ground_albedo;
  float coverage;
  float sky_light_scale, ground_bounce_scale;
  uint traced;  // the ground's share is of a ground whose albedo and shadow are in it
} push;

vec3 key_at(FrameConstants f, float height_m, float mu) {
  return kVolume ? tabled_key_illuminance(f, height_m, mu) : key_illuminance(f, height_m, mu);
}
vec3 sky_at(FrameConstants f, float height_m, vec3 up) {
  if (kVolume) return tabled_sky_illuminance(f, height_m, up);
  return sky_illuminance(f, height_m, up) + moon_fill_illuminance(f, height_m, up);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  FrameConstants f = frame.frame_data;
  if (LISTED) {
    if (!listed_pixel(gl_WorkGroupID.x * 256u + gl_LocalInvocationIndex, pixel)) return;
  } else if (any(greaterThanEqual(pixel, ivec2(f.size)))) {
    return;
  }
  vec4 light = texelFetch(light_tex, pixel, 0), near = texelFetch(near_tex, pixel, 0);
  vec2 depths = texelFetch(depths_tex, pixel, 0).rg;
  vec3 dir = pixel_direction(f, vec2(pixel) + 0.5);
  vec3 far_sum = vec3(0.0), near_sum = vec3(0.0);
  int count = depths.x > 0.5 * kFarDepth_m ? 0 : depths.x < depths.y ? 2 : 1;
  for (int i = 0; i < count; ++i) {
    float at = i == 0 ? depths.y : depths.x;
    vec4 part = i == 0 ? vec4(light.rgb - near.rgb, 1.0 - light.a - near.a) : near;
    vec3 p = dir * at;
    vec3 up = geodetic_up(f.planet, p);
    float mu_key = dot(up, f.key_dir);
    float height_m = geodetic_height(f.planet, p);
    vec3 key_lux = key_at(f, height_m, mu_key);
    vec3 sky_lux = sky_at(f, height_m, up) + f.night_illuminance;
    vec3 ground_lux = push.traced != 0u ? key_at(f, 0.0, mu_key) * max(mu_key, 0.0) : push.ground_albedo * (key_lux * max(mu_key, 0.0) * (1.0 - 0.7 * push.coverage) + sky_lux);
    vec3 sent = part.x * key_lux + part.y * push.sky_light_scale * sky_lux + part.z * push.ground_bounce_scale * ground_lux;
    vec3 air_transmittance;
    vec3 air = kVolume ? volume_aerial_perspective(f, dir, at, air_transmittance) : aerial_perspective(f, dir, at, 0.0, air_transmittance);
    sent = sent * air_transmittance + air * part.a;
    if (i == 0) far_sum = sent;
    else near_sum = sent;
  }
  imageStore(out_radiance, pixel, vec4(within_rec709(near_sum + far_sum), light.a));
  imageStore(out_near, pixel, vec4(near_sum, near.a));
}
