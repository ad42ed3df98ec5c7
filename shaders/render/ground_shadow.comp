#version 460
#extension GL_GOOGLE_include_directive : require
// Share of the key light that clouds let through to the surface of every pixel, from their shadow maps. The light's disc
// blurs shadows by its own width times the way from the cloud: where the light is low that is many texels.
#include "common/frame.h"
layout(local_size_x = 16, local_size_y = 16) in;  // a tile
layout(set = 0, binding = 0, scalar) uniform FrameBlock { FrameConstants frame_data; } frame;
#include "clouds/shadow_map.glsl"
layout(set = 0, binding = 20) uniform sampler2D depth_m;
layout(set = 0, binding = 21, r32f) uniform writeonly image2D sun_visibility;
#define PIXEL_TILES_BINDING 22
#include "common/pixel_tiles.glsl"

const int kMostTaps = 8;

// Mean of one cascade over the light's disc, whose radius there is in texels; at most a tile's width, which is there around
// every usable one.
float soft_read(uint k, vec3 p, float radius) {
  // Bilinear reads are as wide as a texel already.
  int taps = radius > 2.0 ? kMostTaps : radius > 0.7 ? 4 : 1;
  float width = taps > 1 ? min(radius, float(kShadowTile)) : 0.0, sum = 0.0;
  for (int i = 0; i < taps; ++i) {
    // Points of equal area each, at golden angles (Vogel 1979).
    float r = width * sqrt((float(i) + 0.5) / float(taps)), a = 2.399963 * float(i);
    sum += shadow_read(k, p, r * vec2(cos(a), sin(a)));
  }
  return sum / float(taps);
}

// cloud_sun_transmittance() of a disc as the point sees it through a layer of clouds at their middle height.
float soft_transmittance(vec3 p) {
  float climb = max(dot(geodetic_up(frame.frame_data.planet, p), SHADOW.light), 0.02);
  float above_m = max(0.5 * (SHADOW.hull_low_m + SHADOW.hull_high_m) - geodetic_height(frame.frame_data.planet, p), 0.0);
  float radius_m = min(above_m / climb, 60.0e3) * frame.frame_data.sun_angular_radius_rad;
  float distance_m = length(p), sum = 0.0, left = 1.0;
  // Where the disc is wider than tiles, the next cascade's.
  uint first = 0u;
  while (first + 1u < SHADOW.cascades && radius_m > float(kShadowTile) * SHADOW.at[first].texel_m) ++first;
  uint k = shadow_cascade_at(p, distance_m, first);
  while (left > 0.0) {
    bool none = k >= SHADOW.cascades;
    ShadowCascade c = SHADOW.at[min(k, SHADOW.cascades - 1u)];
    float share = none ? left : left * clamp((c.reach_m - distance_m) / (c.reach_m - c.fade_m), 0.0, 1.0);
    sum += share * (none ? shadow_outside(p) : soft_read(k, p, radius_m / c.texel_m));
    left -= share;
    if (left > 0.0) k = shadow_cascade_at(p, distance_m, k + 1u);
  }
  return sum;
}

void main() {
  ivec2 pixel = ivec2(tile_pixel());
  if (any(greaterThanEqual(pixel, ivec2(frame.frame_data.size)))) return;
  float distance = texelFetch(depth_m, pixel, 0).r;
  bool surface = distance < 0.5 * kFarDepth_m;
  float visible = 1.0;
  if (surface && SHADOW.cascades > 0u) visible = soft_transmittance(pixel_direction(frame.frame_data, vec2(pixel) + 0.5) * distance);
  imageStore(sun_visibility, pixel, vec4(visible));
}
