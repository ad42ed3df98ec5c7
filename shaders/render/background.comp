#version 460
#extension GL_GOOGLE_include_directive : require
// What lies behind the clouds, as the camera sees it through clear air: the lit surface, or the sky with its stars. Sun and
// moon come later (discs.comp).
#include "common/frame.h"
#include "common/gamut.h"
#include "common/water.h"
#include "render/render_shared.h"

layout(local_size_x = 16, local_size_y = 16) in;  // a tile
layout(set = 0, binding = 0, scalar) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1) uniform sampler2D depth_m;         // m along the ray, kFarDepth_m for the sky
layout(set = 0, binding = 2) uniform sampler2D albedo;          // a: 0 sky, 1 land, 2 water
layout(set = 0, binding = 3) uniform sampler2D normal;          // unit, ECEF axes
layout(set = 0, binding = 4) uniform sampler2D emission;        // city lights, 0..1
layout(set = 0, binding = 5) uniform sampler2D sun_visible_share;  // of the surface, through clouds
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2D background;
layout(set = 0, binding = 15) uniform sampler2D cloud_light;  // of light_gather.comp, SURFACE
#define ATMOSPHERE_BINDING 8
#include "atmosphere/atmosphere_lookup.glsl"
#define PIXEL_TILES_BINDING 7
#include "common/pixel_tiles.glsl"
#define NIGHT_SKY_BINDING 16
#include "render/night_sky.glsl"
#define AIR_VOLUME_BINDING 26
#include "atmosphere/air_volume.glsl"
// Constant 0 is the number of spectral groups.
layout(constant_id = 1) const bool kNight = true;  // false: by day; stars and airglow are left out
layout(constant_id = 2) const uint HAZE = 0u;          // layers of haze
layout(constant_id = 3) const bool kVolume = false;    // the air and the lights are read from the air volume
#define HAZE_GROUND_BINDING 24
#include "render/haze_ground.glsl"
layout(push_constant, scalar) uniform PushBlock { BackgroundPush push; };

// Illuminance of horizontal ground by light that clouds scattered, in shares of key light, sky light, and key light on the
// ground: from the 4 x 4 nodes around the pixel by a cubic B-spline, which evens out their noise (in a sequence 3 x 3 and quadratic); those
// the more whose ground is about as far away.
vec3 cloud_light_shares(FrameConstants f, ivec2 pixel, float distance) {
  vec2 at = (vec2(pixel) + 0.5) * vec2(push.light_nodes) / vec2(f.size) - 0.5;
  vec2 low = floor(kVolume ? at + 0.5 : at), u = at - low;
  vec4 sum = vec4(0.0);
  int wide = kVolume ? 3 : 4;
  for (int i = 0; i < wide * wide; ++i) {
    ivec2 step = ivec2(i % wide, i / wide) - 1;
    ivec2 node = clamp(ivec2(low) + step, ivec2(0), ivec2(push.light_nodes) - 1);
    vec4 there = texelFetch(cloud_light, node, 0);
    float apart = abs(there.a - distance) / distance;
    vec2 x = abs(vec2(step) - u);
    vec2 inner = 2.0 / 3.0 - x * x * (1.0 - 0.5 * x), outer = max(2.0 - x, vec2(0.0));
    vec2 w = mix(outer * outer * outer / 6.0, inner, lessThan(x, vec2(1.0)));
    if (kVolume) {
      vec2 side = max(1.5 - x, vec2(0.0));
      w = mix(0.5 * side * side, 0.75 - x * x, lessThan(x, vec2(0.5)));
    }
    float weight = there.a < 0.5 * kFarDepth_m ? (w.x * w.y + 1.0e-5) / (0.1 + apart) : 0.0;
    sum += weight * vec4(there.rgb, 1.0);
  }
  return sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0, 1.0, 0.0);
}

vec3 key_lux(FrameConstants f, float height, float mu) {
  return kVolume ? tabled_key_illuminance(f, height, mu) : key_illuminance(f, height, mu);
}
// Of sky and moon.
vec3 sky_lux(FrameConstants f, float height, vec3 up) {
  if (kVolume) return tabled_sky_illuminance(f, height, up);
  return sky_illuminance(f, height, up) + (kNight ? moon_fill_illuminance(f, height, up) : vec3(0));
}

// What leaves the surface towards the eye.
vec3 surface_luminance(FrameConstants f, ivec2 pixel, vec3 dir, float distance, vec4 surface) {
  vec3 point = dir * distance;
  vec3 up = geodetic_up(f.planet, point);
  float height = geodetic_height(f.planet, point);
  vec3 n = texelFetch(normal, pixel, 0).xyz;
  n = dot(n, n) > 0.25 ? normalize(n) : up;
  float mu_key = dot(up, f.key_dir);
  float visibility = push.has_cloud_shadow != 0u ? texelFetch(sun_visible_share, pixel, 0).r : 1.0;
  vec3 open_key = key_lux(f, height, mu_key), key = open_key * visibility;
  vec3 sky = sky_lux(f, height, up) + (kNight ? night_illuminance_lux() : vec3(0));
  if (HAZE > 0u) {
    HazeGround haze = haze_over_ground(point, mu_key);
    sky = sky * haze.sky + key * haze.scattered;
    key *= haze.beam;
  }
  float sky_share = 1.0;
  vec3 from_clouds = vec3(0.0);
  if (push.light_nodes.x > 0u) {
    vec3 shares = cloud_light_shares(f, pixel, distance);
    sky_share = shares.y;
    from_clouds = open_key * (shares.x + shares.z * max(mu_key, 0.0));
    sky = sky * sky_share + from_clouds;
  }
  float lit = max(dot(n, f.key_dir), 0.0);
  float open = 0.5 + 0.5 * dot(n, up);  // share of the sky that a slope sees; the rest is lit ground
  vec3 below = (key * max(mu_key, 0.0) + sky) * push.ground_albedo;
  vec3 illuminance = key * lit + sky * open + below * (1.0 - open);
  vec3 result = surface.rgb * illuminance * (1.0 / kPi);
  // A loop of one turn or none, which a software device leaves out where a branch would run for every pixel.
  for (int i = 0; i < int(surface.a > 1.5); ++i) {
    // Water: the sky mirrored by a rough surface, the light's glint, and what little comes back from below.
    float slopes = water_slope_variance(push.wind_mps);
    float cos_v = max(dot(up, -dir), 1.0e-3);
    // Seen flat, the visible facets lean towards the eye and mirror a higher part of the sky.
    vec3 mirrored = reflect(dir, up);
    mirrored = normalize(mirrored + up * sqrt(slopes) * (1.0 - cos_v));
    // Clouds are mirrored as what they are on average.
    vec3 reflected = (mirrored_sky_luminance(f, up, mirrored) + (kNight ? night_illuminance_lux() / kPi : vec3(0))) * sky_share + from_clouds / kPi;
    float fresnel = fresnel_rough(cos_v, 0.5 * slopes);
    vec3 body = water_body_albedo() * (key * max(mu_key, 0.0) + sky) * (1.0 / kPi);
    result = fresnel * reflected + (1.0 - fresnel) * body + key * sun_glint_per_sr(up, -dir, f.key_dir, slopes);
  }
  return result + texelFetch(emission, pixel, 0).rgb * push.night_light_cd_m2;
}

void main() {
  ivec2 pixel = ivec2(tile_pixel());
  FrameConstants f = frame.frame_data;
  if (any(greaterThanEqual(pixel, ivec2(f.size)))) return;
  vec3 dir = pixel_direction(f, vec2(pixel) + 0.5);
  float distance = texelFetch(depth_m, pixel, 0).r;
  vec4 surface = texelFetch(albedo, pixel, 0);
  bool is_sky = distance >= 0.5 * kFarDepth_m || surface.a < 0.5;
  vec3 through, air, behind = vec3(0);
  if (!kVolume) air = air_luminance(f, dir, is_sky, distance, through);
  for (int i = 0; i < int(is_sky); ++i) {
    if (kVolume) air = sky_view_luminance(f, dir, kNight, through);
    if (kNight) behind = stars_luminance(f, pixel) * through;
  }
  for (int i = 0; i < int(!is_sky); ++i) {
    if (kVolume) air = volume_aerial_perspective(f, dir, distance, through);
    behind = surface_luminance(f, pixel, dir, distance, surface) * through;
  }
  if (kNight) behind += airglow_luminance(f, dir, !is_sky, through) + night_air_luminance(through);
  imageStore(background, pixel, vec4(within_rec709(air + behind), 1.0));
}
