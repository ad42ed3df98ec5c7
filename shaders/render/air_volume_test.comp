#version 460
#extension GL_GOOGLE_include_directive : require
// For tests: air and light at points by the air volume, and by the exact functions.
#include "common/frame.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define ATMOSPHERE_BINDING 8
#include "atmosphere/atmosphere_lookup.glsl"
#define AIR_VOLUME_BINDING 16
#include "atmosphere/air_volume.glsl"
struct Place { vec2 pixel; float distance_m; };
struct Answer { vec3 air, through, key, sky; };
layout(scalar, set = 0, binding = 1) readonly buffer PlaceBlock { Place at[]; } places;
layout(scalar, set = 0, binding = 2) writeonly buffer AnswerBlock { Answer at[]; } answers;  // exact, by the volume

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= places.at.length()) return;
  FrameConstants f = frame.frame_data;
  Place place = places.at[i];
  vec3 dir = pixel_direction(f, place.pixel), p = dir * place.distance_m, up = geodetic_up(f.planet, p);
  float height_m = geodetic_height(f.planet, p);
  Answer exact, quick;
  exact.air = aerial_perspective(f, dir, place.distance_m, 0.0, exact.through);
  exact.key = key_illuminance(f, height_m, dot(up, f.key_dir));
  exact.sky = sky_illuminance(f, height_m, up) + moon_fill_illuminance(f, height_m, up);
  quick.air = volume_aerial_perspective(f, dir, place.distance_m, quick.through);
  quick.key = tabled_key_illuminance(f, height_m, dot(up, f.key_dir));
  quick.sky = tabled_sky_illuminance(f, height_m, up);
  answers.at[2 * i] = exact;
  answers.at[2 * i + 1] = quick;
}
