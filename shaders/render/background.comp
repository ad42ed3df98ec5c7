#version 460
#extension GL_GOOGLE_include_directive : require
// What lies behind the clouds, as the camera sees it through clear air: the lit surface, or the sky with the sun's disc.
#include "common/frame.h"
#include "common/water.h"
#include "render/render_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, scalar) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1) uniform sampler2D depth_m;         // m along the ray, kFarDepth_m for the sky
layout(set = 0, binding = 2) uniform sampler2D albedo;          // a: 0 sky, 1 land, 2 water
layout(set = 0, binding = 3) uniform sampler2D normal;          // unit, ECEF axes
layout(set = 0, binding = 4) uniform sampler2D emission;        // city lights, 0..1
layout(set = 0, binding = 5) uniform sampler2D sun_visible_share;  // of the surface, through clouds
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2D background;
#define ATMOSPHERE_BINDING 8
#include "atmosphere/atmosphere_lookup.glsl"
layout(push_constant, scalar) uniform PushBlock { BackgroundPush push; };

// One sky lookup serves both what is seen and what water mirrors: the shader stays small.
void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  FrameConstants f = frame.frame_data;
  if (any(greaterThanEqual(pixel, ivec2(f.size)))) return;
  vec3 dir = pixel_direction(f, vec2(pixel) + 0.5);
  float distance = texelFetch(depth_m, pixel, 0).r;
  vec4 surface = texelFetch(albedo, pixel, 0);
  vec3 result;
  if (distance >= 0.5 * kFarDepth_m || surface.a < 0.5) {
    vec3 through;
    result = sky_luminance(f, dir, false, through);
    result += sun_disc_luminance(f, dir, through);
  } else {
    vec3 point = dir * distance;
    vec3 up = geodetic_up(f.planet, point);
    float height = geodetic_height(f.planet, point);
    float mu_s = dot(up, f.sun_dir);
    vec3 n = texelFetch(normal, pixel, 0).xyz;
    n = dot(n, n) > 0.25 ? normalize(n) : up;
    float visibility = push.has_cloud_shadow != 0u ? texelFetch(sun_visible_share, pixel, 0).r : 1.0;
    vec3 sun = sun_illuminance(f, height, mu_s) * visibility;
    vec3 sky = sky_illuminance(f, height, mu_s);
    if (surface.a > 1.5) {
      // Water: the sky mirrored by a rough surface, the sun's glint, and what little comes back from below.
      float slopes = water_slope_variance(push.wind_mps);
      float cos_v = max(dot(up, -dir), 1.0e-3);
      // Seen flat, the visible facets lean towards the eye and mirror a higher part of the sky.
      vec3 mirrored = reflect(dir, up);
      mirrored = normalize(mirrored + up * sqrt(slopes) * (1.0 - cos_v));
      vec3 reflected = sky_luminance_at(f, point, mirrored);
      float fresnel = fresnel_rough(cos_v, 0.5 * slopes);
      vec3 body = water_body_albedo() * (sun * max(mu_s, 0.0) + sky) * (1.0 / kPi);
      result = fresnel * reflected + (1.0 - fresnel) * body + sun * sun_glint_per_sr(up, -dir, f.sun_dir, slopes);
    } else {
      float lit = max(dot(n, f.sun_dir), 0.0);
      float open = 0.5 + 0.5 * dot(n, up);  // share of the sky that a slope sees; the rest is lit ground
      vec3 below = (sun * max(mu_s, 0.0) + sky) * push.ground_albedo;
      vec3 illuminance = sun * lit + sky * open + below * (1.0 - open);
      result = surface.rgb * illuminance * (1.0 / kPi);
    }
    result += texelFetch(emission, pixel, 0).rgb * push.night_light_cd_m2;
    vec3 through;
    vec3 air = aerial_perspective(f, dir, distance, through);
    result = result * through + air;
  }
  imageStore(background, pixel, vec4(result, 1.0));
}
