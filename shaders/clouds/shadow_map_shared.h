// Data and pure functions of the clouds' shadow maps, for C++ and GLSL (docs/light.md, 'Shadow maps').
#ifndef NEPHO_CLOUDS_SHADOW_MAP_SHARED_H
#define NEPHO_CLOUDS_SHADOW_MAP_SHARED_H
#include "common/shared.h"
SHARED_BEGIN

// A cascade is a square window of a plane across the light, on a grid that is fixed to the Earth. It is marched in tiles;
// a tile's storage place is its place in the grid modulo the window, so that a window that moves keeps what it has.
SHARED_CONST uint kShadowCascades = 4u;
SHARED_CONST uint kShadowTile = 8u;          // texels along a side
SHARED_CONST uint kShadowResolution = 1024u;  // most texels along a side of a cascade
SHARED_CONST uint kShadowWords = 512u;       // bits of a cascade's tiles: (1024 / 8)^2 / 32
SHARED_CONST uint kShadowSlabs = 64u;        // pieces of a light ray's way through the clouds, at most

struct ShadowCascade {
  vec3 corner;         // of texel (0, 0) of the window, at depth 0: camera-relative, ECEF axes, m
  float texel_m;
  uvec2 first;         // storage place of that texel
  float depth_unit_m;  // of stored depths
  float reach_m;       // distance from the camera up to which it is used
  float fade_m;        // from here on it gives way to the next
  float high_m, low_m;  // of the depths that points in view have: towards the light, and away from it
  uint slabs;          // pieces that its rays are cut into
};

struct ShadowMaps {
  vec3 axis_x;          // of the plane, unit
  uint cascades;        // 0: no shadows
  vec3 axis_y;
  uint resolution;      // texels along a side, a multiple of kShadowTile
  vec3 light;           // unit, towards the light
  float outside;        // transmittance below the clouds where no map is, for light from the zenith
  float slant;          // and how fast it falls where light is slanting: shadow_beyond()
  float hull_low_m, hull_high_m;  // geodetic heights between which clouds cast shadows
  float thickness_m;    // of the thinnest casting layer
  ShadowCascade at[4];
  uint usable[2048];    // a bit per tile of the window, row by row: it and its neighbours are marched
};

// Mean transmittance of broken clouds to slanting light, mu the cosine of its zenith angle: cylinders that stand at random, whose shadows grow
// with their height times the tangent (Kauth and Penquite 1967); slant: 4/pi of height over width.
SHARED_FN float shadow_beyond(float outside, float slant, float mu) {
  float c = clamp(mu, 0.05f, 1.0f);
  return pow(outside, 1.0f + slant * sqrt(1.0f - c * c) / c);
}

// A tile to be marched.
struct ShadowTileWork {
  uint cascade;
  uint x, y;     // in tiles of the window
  uint round;    // how many marches its texels are the mean of already
};

// What a texel holds: along its ray, away from the light, the depths at which the optical depth reaches kShadowKnots, in units
// of depth_unit_m from (-32768) units on; then the depth behind which there is no more cloud, and the optical depth there.
// Where clouds are smaller than a texel the two disagree: a point inside is in the thick of one, a point behind may see the
// light past all of them.
// A knot that is never reached lies on the line through the last one and the end, where that is, and at the far end beyond.
SHARED_CONST int kShadowKnotCount = 6;
SHARED_CONST float kShadowDeepest = 8.0f;  // marches stop there
SHARED_FN float shadow_knot(int i) {
  return i == 0 ? 0.0f : i == 1 ? 0.25f : i == 2 ? 0.6f : i == 3 ? 1.1f : i == 4 ? 1.9f : 3.2f;
}
struct ShadowTexel {
  float at[6];   // depths, 0..65535
  float depth;   // whole optical depth, for points behind
  float end;
};

// 16 bit each.
SHARED_FN uint shadow_pair(float low, float high) {
  return uint(clamp(low, 0.0f, 65535.0f) + 0.5f) | (uint(clamp(high, 0.0f, 65535.0f) + 0.5f) << 16u);
}
SHARED_FN uvec4 shadow_pack(ShadowTexel t) {
  return uvec4(shadow_pair(t.at[0], t.at[1]), shadow_pair(t.at[2], t.at[3]), shadow_pair(t.at[4], t.at[5]),
               shadow_pair(t.depth * (65535.0f / kShadowDeepest), t.end));
}

// Part of the way from a to b at which x is, 0..1; steps where they are the same.
SHARED_FN float shadow_ramp(float x, float a, float b) { return clamp((x - a) / max(b - a, 0.5f), 0.0f, 1.0f); }

// Optical depth between the light and a point at depth x (0..65535) of a texel.
SHARED_FN float shadow_depth_at(uvec4 texel, float x) {
  float a0 = float(texel.x & 0xffffu), a1 = float(texel.x >> 16u), a2 = float(texel.y & 0xffffu), a3 = float(texel.y >> 16u);
  float a4 = float(texel.z & 0xffffu), a5 = float(texel.z >> 16u);
  float whole = float(texel.w & 0xffffu) * (kShadowDeepest / 65535.0f), end = float(texel.w >> 16u);
  float depth = 0.25f * shadow_ramp(x, a0, a1) + 0.35f * shadow_ramp(x, a1, a2) + 0.5f * shadow_ramp(x, a2, a3) + 0.8f * shadow_ramp(x, a3, a4) +
                1.3f * shadow_ramp(x, a4, a5) + max(whole - 3.2f, 0.0f) * shadow_ramp(x, a5, end);
  return x >= end ? whole : depth;
}

// A texel of the window's place in storage.
SHARED_FN uvec2 shadow_place(ShadowCascade c, uvec2 texel, uint resolution) {
  uvec2 at = texel + c.first;
  return uvec2(at.x >= resolution ? at.x - resolution : at.x, at.y >= resolution ? at.y - resolution : at.y);
}

SHARED_END
#endif
