#version 460
#extension GL_GOOGLE_include_directive : require
// Shafts (and haze) by a march of every ray through the clouds' shade.
#include "common/frame.h"
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/shadow_map.glsl"
#include "clouds/shadow_ray.glsl"
#define ATMOSPHERE_BINDING 12
#include "atmosphere/atmosphere_lookup.glsl"
#define SHAFT_BINDING 19
#define TERRAIN_VOLUME_BINDING 40
#define TERRAIN_CONSTANT 9
#include "terrain/terrain_air.glsl"
#include "terrain/terrain_ray.glsl"
#define AIR_VISIBLE(p) (QUICK ? terrain_share_on(shade, m, at, p) : 1.0)
#define AIR_BLOCK(block)
#define AIR_RAY(dir) ShadowRay shade = shadow_ray(dir, frame.frame_data.camera_up);
#define AIR_LOOK(t, number) (QUICK ? shadow_ray_look(shade, t, shadow_shift(number)) : cloud_sun_transmittance(dir * (t)) * terrain_air_share(dir * (t)))
#define AIR_LOOKS 3
#include "render/shaft_air.glsl"
float terrain_share_on(ShadowRay shade, AirMarch m, float t_m, vec3 p) {
  PlanetView planet = frame.frame_data.planet;
  float h = shadow_ray_height(shade, t_m), start_h = shadow_ray_height(shade, m.ray.start_m);
  float mu = (m.ray.mu_s * (planet.a_m + start_h) + (t_m - m.ray.start_m) * m.ray.stretch * m.ray.nu) / (planet.a_m + h);
  return terrain_ray_share(p, h, h * shade.geodetic, mu);
}
#include "render/shaft_march.glsl"
