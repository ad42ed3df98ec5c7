#version 460
#extension GL_GOOGLE_include_directive : require
// False-colour pictures of what the clouds are made from (docs/debug_views.md has the legends).
#include "common/frame.h"
#include "render/debug_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_density.glsl"
#include "clouds/shadow_map.glsl"
layout(set = 0, binding = 20) uniform sampler2D cloud_radiance;
layout(set = 0, binding = 21) uniform sampler2D cloud_info;
layout(set = 0, binding = 22) uniform sampler2D depth_m;
layout(set = 0, binding = 23, rgba8) uniform writeonly image2D display;
layout(push_constant, scalar) uniform Push { uint view; } push;

// Coverage of the channels where the ray meets the middle of the lowest layer: R, G, B as red, green, blue; A whitens.
vec3 weather_color(vec3 dir, float surface_m) {
  float middle_m = CLOUD.layers[0].base_m + 0.5 * CLOUD.layers[0].thickness_m;
  vec2 t;
  if (!intersect_shell(CLOUD_PLANET, dir, middle_m, t) || t.y <= 0.0) return vec3(0.0);
  float at = t.x > 0.0 ? t.x : t.y;
  if (at > surface_m) return vec3(0.0);
  vec3 p = dir * at;
  vec3 up = geodetic_up(CLOUD_PLANET, p);
  float log2_footprint = log2(max(frame.frame_data.pixel_angle_rad * at, 1.0));
  CloudWeather w = cloud_weather_at(p, up, log2_footprint);
  vec4 c = w.coverage;
  for (uint l = 0u; l < LAYERS; ++l) {
    CloudColumn column = cloud_column(l, w, p, up, middle_m, log2_footprint);
    float value = dot(CLOUD.layers[l].channel, w.coverage), wc = CLOUD.layers[l].cell_weight;
    float share = value <= 0.0 ? 0.0 : value >= 1.0 ? 1.0 : share_from_probit((probit_from_share(value) + column.slow) / sqrt(wc * wc + column.unknown));
    c = mix(c, vec4(share), CLOUD.layers[l].channel);
  }
  return mix(c.rgb, vec3(1.0), 0.7 * c.a);
}

// The cascade that the surface's shadow comes from, as a colour, dark in the shadow; every other tile of it is paler.
vec3 shadow_color(vec3 dir, float surface_m) {
  bool sky = surface_m >= 0.5 * kFarDepth_m;
  vec3 p = dir * (sky ? 0.0 : surface_m);
  uint k = SHADOW.cascades > 0u ? shadow_cascade_at(p, length(p), 0u) : 0u;
  vec3 color = vec3(0.6);
  if (k < SHADOW.cascades) {
    uvec2 tile = (uvec2(shadow_point(SHADOW.at[k], p).xy) + SHADOW.at[k].first) / kShadowTile;
    color = layer_color(k) * ((tile.x + tile.y) % 2u == 0u ? 1.0 : 0.8);
  }
  return sky ? vec3(0.0) : color * (0.15 + 0.85 * cloud_sun_transmittance(p));
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, ivec2(frame.frame_data.size)))) return;
  vec4 info = texelFetch(cloud_info, pixel, 0);
  float opacity = 1.0 - texelFetch(cloud_radiance, pixel, 0).a;
  vec3 color = vec3(0.0);
  float steps = mod(info.w, 1024.0), samples = floor(info.w / 1024.0);
  if (push.view == kDebugWeather) color = weather_color(pixel_direction(frame.frame_data, vec2(pixel) + 0.5), texelFetch(depth_m, pixel, 0).r);
  if (push.view == kDebugDensity && info.y > 0.0) color = turbo(depth_shade(info.y));
  if (push.view == kDebugLayers && info.z > 0.5) color = layer_color(uint(info.z - 0.5)) * (0.25 + 0.75 * opacity);
  if (push.view == kDebugSamples) color = turbo(samples / 256.0);
  if (push.view == kDebugSteps) color = turbo(steps / 256.0);
  if (push.view == kDebugShadows) color = shadow_color(pixel_direction(frame.frame_data, vec2(pixel) + 0.5), texelFetch(depth_m, pixel, 0).r);
  imageStore(display, pixel, vec4(color, 1.0));
}
