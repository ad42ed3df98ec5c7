// Temporal upscaling of the clouds: patterns, reprojection and the rules for history. Data and pure functions for C++ and GLSL
// (docs/performance.md, 'Temporal upscaling').
#ifndef NEPHO_CLOUDS_UPSCALE_SHARED_H
#define NEPHO_CLOUDS_UPSCALE_SHARED_H
#include "common/frame.h"
SHARED_BEGIN

SHARED_CONST float kMostSamples = 64.0f;   // that history stands for, at most
SHARED_CONST float kMovingSamples = 12.0f; // the same where the picture moves by a pixel a frame or more
SHARED_CONST float kBoxSide = 2.0f;        // half side of the box for history of moving pictures, in standard deviations
SHARED_CONST float kBoxLeast = 0.02f;      // and at least, of the luminance and of the transmittance
SHARED_CONST float kNoParallax_px = 0.1f;   // movement in a frame that is not the camera's turn: below the first there is no box,
SHARED_CONST float kMuchParallax_px = 1.5f; // from the second on it has its full effect
SHARED_CONST float kNearlySame = 0.1f;     // share by which two distances of a surface may differ
SHARED_CONST float kStraySplit_px = 1.5f;  // where history's two answers about the same place are farther apart, it has none
SHARED_CONST float kMostParallax = 0.25f;  // way of the camera in a frame, as a share of a cloud's distance

// What a frame knows of the one before; one uniform block.
struct UpscaleConstants {
  vec3 forward;   // of the camera then, as in FrameConstants
  uint upscale;   // 16, 4, 2: pixels per marched one
  vec3 right;     // over its squared length
  uint still;     // 1: the camera has neither moved nor turned
  vec3 up;        // over its squared length
  uint number;    // of the frame since the last one without history, which was 0
  vec3 shift_m;   // from a point seen from the camera now to the same piece of cloud seen from the camera then
  float most_samples;  // that history may stand for, so that it is not older than clouds and light last
  ivec2 base;     // a pixel of this frame's pattern; the others are at base + i step_x + j step_y
  ivec2 step_x, step_y;
};

// Place of rank 0..3 in a 2 x 2 block in Bayer's order.
SHARED_FN ivec2 bayer2_place(uint rank) { return ivec2(int((rank ^ (rank >> 1)) & 1u), int(rank & 1u)); }

// The pixel of a 4 x 4 block that is marched in frame number `number`: ranks of Bayer's matrix.
SHARED_FN ivec2 bayer4_place(uint number) { return 2 * bayer2_place(number & 3u) + bayer2_place((number >> 2) & 3u); }

// The pixel of a 2 x 2 block: quarters of the unit square in the order in which the Halton sequence (2, 3) first enters them.
SHARED_FN ivec2 halton4_place(uint number) {
  uint i = number & 3u;
  return ivec2(int(i == 0u || i == 3u), int(i == 1u || i == 3u));
}

// Radical inverse, 0..1.
SHARED_FN float upscale_halton(uint index, uint base) {
  float f = 1.0f, r = 0.0f;
  for (uint i = index; i > 0u; i /= base) {
    f /= float(base);
    r += f * float(i % base);
  }
  return r;
}

// Offset of a frame's rays within their pixels, -0.5..0.5: each pixel's own visits walk through a Halton sequence, which begins at its
// centre.
SHARED_FN vec2 upscale_jitter_px(uint number, uint upscale) {
  uint visit = number / upscale;
  if (visit == 0u) return vec2(0.0f);
  return vec2(upscale_halton(visit, 2u) - 0.5f, upscale_halton(visit, 3u) - 0.5f);
}

// True for pixels of a frame's pattern.
SHARED_FN bool in_pattern(UpscaleConstants u, ivec2 pixel) {
  ivec2 from = pixel - u.base;
  if (u.upscale == 2u) return ((from.x + from.y) & 1) == 0;
  return (from.x & (u.step_x.x - 1)) == 0 && (from.y & (u.step_y.y - 1)) == 0;
}

// The pixel of the pattern that is nearest to a pixel.
SHARED_FN ivec2 nearest_in_pattern(UpscaleConstants u, ivec2 pixel) {
  ivec2 from = pixel - u.base;
  if (u.upscale == 2u) return pixel + ivec2((from.x + from.y) & 1, 0);
  int side = u.step_x.x, half_side = side / 2;
  return u.base + ivec2((from.x + half_side) & ~(side - 1), (from.y + half_side) & ~(side - 1));
}

// Where a direction or a point relative to the camera then was in the picture, in pixels (centres at +0.5). False: behind the camera.
SHARED_FN bool previous_pixel(UpscaleConstants u, uvec2 size, vec3 p_m, SHARED_OUT(vec2) at_px) {
  float z = dot(p_m, u.forward);
  float inv = 1.0f / max(z, 1.0e-6f);
  float x = dot(p_m, u.right) * inv, y = dot(p_m, u.up) * inv;
  at_px = vec2((0.5f + 0.5f * x) * float(size.x), (0.5f - 0.5f * y) * float(size.y));
  return z > 1.0e-6f;
}

// Luminance, orange-blue, green-magenta: errors of history show in luminance first.
SHARED_FN vec3 ycocg_from_rgb(vec3 c) {
  return vec3(0.25f * c.x + 0.5f * c.y + 0.25f * c.z, 0.5f * (c.x - c.z), 0.5f * c.y - 0.25f * (c.x + c.z));
}
SHARED_FN vec3 rgb_from_ycocg(vec3 c) {
  float t = c.x - c.z;
  return vec3(t + c.y, c.x + c.z, t - c.y);
}

// How far outside a box around `mean` a value is: 1 on its faces. Towards the mean by that factor is a clip, which keeps the hue of the
// difference; a clamp would bend it.
SHARED_FN float outside_box(vec4 value, vec4 mean, vec4 half_side) {
  vec4 off = vec4(abs(value.x - mean.x), abs(value.y - mean.y), abs(value.z - mean.z), abs(value.w - mean.w));
  return max(max(off.x / half_side.x, off.y / half_side.y), max(off.z / half_side.z, off.w / half_side.w));
}
SHARED_FN vec4 clip_to_box(vec4 value, vec4 mean, vec4 half_side) {
  float outside = outside_box(value, mean, half_side);
  return outside > 1.0f ? mean + (value - mean) / outside : value;
}

// Weights of Catmull-Rom's cubic for the texels -1, 0, 1, 2 around a place at u = 0..1 between 0 and 1.
SHARED_FN vec4 catmull_rom(float u) {
  return vec4(u * (-0.5f + u * (1.0f - 0.5f * u)), 1.0f + u * u * (-2.5f + 1.5f * u), u * (0.5f + u * (2.0f - 1.5f * u)),
              u * u * (-0.5f + 0.5f * u));
}

// Samples that history may stand for where the picture moves by `px` a frame.
SHARED_FN float most_samples(float px) { return mix(kMostSamples, kMovingSamples, clamp(px, 0.0f, 1.0f)); }

// What is left of a history of n samples that was `outside` times too far from what is seen now.
SHARED_FN float samples_left(float n, float outside) { return outside > 1.0f ? n / (outside * outside) : n; }

// Weight of a new sample where history stands for n: the mean of n + 1. A sample much brighter than what it would join counts for less,
// so that lone sparks do not flash.
SHARED_FN float new_weight(float n, float luminance, float luminance_before) {
  float bright = luminance_before > 0.0f ? max(luminance / luminance_before - 2.0f, 0.0f) : 0.0f;
  return n < 0.5f ? 1.0f : 1.0f / (n * (1.0f + bright) + 1.0f);
}

SHARED_END
#endif
