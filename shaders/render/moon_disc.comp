#version 460
#extension GL_GOOGLE_include_directive : require
// The moon's disc, lit by the sun and the Earth, over the stars of the pixels around it.
#include "render/night_sky_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, scalar) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1, scalar) uniform NightSkyBlock { NightSkyUniform night_sky_data; } night_sky;
layout(set = 0, binding = 2, scalar) buffer SkyPixelBlock { uint values[]; } sky_pixels;
layout(set = 0, binding = 3) uniform sampler2D moon_map;
layout(push_constant, scalar) uniform PushBlock { MoonDiscPush push; };

void main() {
  ivec2 pixel = push.first_px + ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, push.end_px))) return;
  FrameConstants f = frame.frame_data;
  NightSkyUniform n = night_sky.night_sky_data;
  vec3 dir = pixel_direction(f, vec2(pixel) + 0.5);
  float cover = moon_disc_cover(f, dir);
  if (cover <= 0.0) return;
  uint at = 3u * (uint(pixel.y) * f.size.x + uint(pixel.x));
  uvec3 word = uvec3(sky_pixels.values[at], sky_pixels.values[at + 1u], sky_pixels.values[at + 2u]);
  vec3 behind = sky_pixel_luminance(n, word, pixel_solid_angle_sr(f, vec2(pixel) + 0.5));

  float mu;
  vec3 normal = moon_normal(f, dir, mu);
  float pixels = f.moon_angular_radius_rad / f.pixel_angle_rad;
  float lod = log2(max(float(textureSize(moon_map, 0).y) / (kPi * max(pixels, 1.0e-3)), 1.0));
  float albedo = textureLod(moon_map, moon_map_uv(n.moon_from_ecef * normal), lod).r;
  // Phases of a disc of a few pixels become its mean.
  float resolved = smoothstep(1.5, 4.0, pixels);
  float shading = mix(n.moon_mean, albedo * lunar_shading(dot(normal, n.sun_from_moon), mu, n.lunar_lambert), resolved);
  albedo = mix(n.moon_mean_albedo, albedo, resolved);
  vec3 disc = (shading * n.moon_luminance + albedo * n.earthshine_luminance) * (cover * moon_disc_dimming(f));
  uvec3 luminance = sky_pixel_word(behind * (1.0 - cover) + disc);
  sky_pixels.values[at] = luminance.x;
  sky_pixels.values[at + 1u] = luminance.y;
  sky_pixels.values[at + 2u] = luminance.z;
}
