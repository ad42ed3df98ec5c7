#version 460
#extension GL_GOOGLE_include_directive : require
// Clouds of every pixel of an upscaled picture: what was marched this frame, joined with what the last frames saw there.
#include "common/frame.h"
#include "clouds/upscale_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 1) const bool FIRST = false;  // every pixel was marched and nothing is known of before: only fills the history
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(scalar, set = 0, binding = 1) uniform UpscaleBlock { UpscaleConstants data; } upscale;
layout(set = 0, binding = 2) uniform sampler2D depth_m;
layout(set = 0, binding = 3) uniform sampler2D last_radiance;
layout(set = 0, binding = 4) uniform sampler2D last_place;
layout(set = 0, binding = 5) uniform sampler2D last_smooth;     // last_radiance between its texels
layout(set = 0, binding = 6) uniform sampler2D cloud_radiance;  // with its air; only where info.w >= 0
layout(set = 0, binding = 7) uniform sampler2D cloud_info;
layout(set = 0, binding = 8, rgba32f) uniform writeonly image2D out_radiance;
layout(set = 0, binding = 9, rg32f) uniform writeonly image2D out_place;
layout(set = 0, binding = 10, rgba32f) uniform writeonly image2D out_info;
#include "clouds/upscale_history.glsl"

vec4 to_box_space(vec4 c) { return vec4(ycocg_from_rgb(c.rgb), c.a); }
vec4 from_box_space(vec4 c) { return vec4(max(rgb_from_ycocg(c.xyz), vec3(0.0)), clamp(c.w, 0.0, 1.0)); }

// Catmull-Rom's cubic by nine readings between texels.
vec4 sharp_history(vec2 at_px) {
  vec2 size = vec2(frame.frame_data.size), low = floor(at_px - 0.5) + 0.5, part = at_px - low;
  vec4 wx = catmull_rom(part.x), wy = catmull_rom(part.y);
  vec3 x = vec3(low.x - 1.0, low.x + wx.z / (wx.y + wx.z), low.x + 2.0) / size.x, wide = vec3(wx.x, wx.y + wx.z, wx.w);
  vec3 y = vec3(low.y - 1.0, low.y + wy.z / (wy.y + wy.z), low.y + 2.0) / size.y, high = vec3(wy.x, wy.y + wy.z, wy.w);
  vec4 sum = vec4(0.0);
  float total = 0.0;
  // The corners weigh next to nothing.
  for (int i = 0; i < 5; ++i) {
    int c = i == 0 ? 0 : i == 4 ? 2 : 1, r = i == 1 ? 0 : i == 3 ? 2 : 1;
    float w = wide[c] * high[r];
    sum += w * textureLod(last_smooth, vec2(x[c], y[r]), 0.0);
    total += w;
  }
  // No darker and no brighter than the texels around: beside an edge the cubic undershoots, and what is dark there would turn black.
  ivec2 corner = ivec2(low), last = ivec2(size) - 1;
  vec4 least = vec4(1.0e9), most = vec4(0.0);
  for (int i = 0; i < 4; ++i) {
    vec4 texel = texelFetch(last_radiance, clamp(corner + ivec2(i & 1, i >> 1), ivec2(0), last), 0);
    least = min(least, texel);
    most = max(most, texel);
  }
  return clamp(sum / total, least, most);
}

// Whether a pixel's ray ends about as far away.
bool same_surface(ivec2 at, float surface_m) {
  float there_m = min(texelFetch(depth_m, at, 0).r, kFarDepth_m);
  return max(there_m, surface_m) < 1.5 * min(there_m, surface_m);
}

void main() {
  FrameConstants f = frame.frame_data;
  UpscaleConstants u = upscale.data;
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, ivec2(f.size)))) return;
  float surface_m = min(texelFetch(depth_m, pixel, 0).r, kFarDepth_m);
  vec4 info = texelFetch(cloud_info, pixel, 0);
  vec4 own = texelFetch(cloud_radiance, pixel, 0);
  if (FIRST) {
    imageStore(out_radiance, pixel, own);
    imageStore(out_place, pixel, vec4(pack_history(info.x, 1.0), surface_m, 0.0, 0.0));
    return;
  }
  bool marched = info.w >= 0.0;
  ivec2 last = ivec2(f.size) - 1;

  // Of this frame's samples around the nearest, for pixels that know no cloud, and its layer. Loops, where an `if` would do: a software
  // device skips a loop that no lane wants, and pays for a branch that none takes.
  ivec2 centre = nearest_in_pattern(u, pixel);
  float closest_m = info.x, layer_m = kFarDepth_m, layer = info.z;
  bool unknown = info.x > 0.5 * kFarDepth_m;
  for (int i = 0; i < (marched && !unknown ? 0 : 9); ++i) {
    ivec2 at = centre + (i % 3 - 1) * u.step_x + (i / 3 - 1) * u.step_y;
    if (any(lessThan(at, ivec2(0))) || any(greaterThan(at, last))) continue;
    vec2 there = texelFetch(cloud_info, at, 0).xz;
    bool nearer = unknown && there.x < closest_m, first = !marched && there.x < layer_m;
    if ((nearer || first) && same_surface(at, surface_m)) {
      if (nearer) closest_m = there.x;
      if (first) {
        layer_m = there.x;
        layer = there.y;
      }
    }
  }
  // Edges move with what is in front.
  if (u.still == 0u)
    for (int i = 0; i < 4; ++i) {
      ivec2 at = clamp(pixel + ivec2(i & 1, 1 - (i & 1)) * (i < 2 ? 1 : -1), ivec2(0), last);
      closest_m = min(closest_m, texelFetch(cloud_info, at, 0).x);
    }

  // What was seen there.
  vec4 before;
  float samples, moved_px = 0.0, parallax_px = 0.0, found = 1.0;
  if (u.still != 0u) {
    vec2 place = texelFetch(last_place, pixel, 0).rg;
    before = texelFetch(last_radiance, pixel, 0);
    samples = float(history_samples(place.x));
    found = surface_fits(surface_m, place, pixel) ? 1.0 : 0.0;
  } else {
    vec3 dir = pixel_direction(f, vec2(pixel) + 0.5 - f.jitter_px);
    vec2 at;
    bool there = previous_pixel(u, f.size, dir * closest_m + shift_of(closest_m), at);
    there = there && all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(f.size)));
    vec4 fits = history_fits(at, length(dir * surface_m + shift_of(surface_m)), closest_m);
    float share = dot(fits, vec4(1.0));
    vec2 low = floor(at - 0.5);
    before = vec4(0.0);
    for (int i = 0; i < (share > 0.999 ? 0 : 4); ++i)
      before += fits[i] / max(share, 1.0e-6) * texelFetch(last_radiance, clamp(ivec2(low) + ivec2(i & 1, i >> 1), ivec2(0), last), 0);
    if (share > 0.999) before = sharp_history(at);
    samples = float(history_samples(texelFetch(last_place, history_texel(at), 0).x));
    moved_px = length(at - vec2(pixel) - 0.5);
    vec2 turned;
    previous_pixel(u, f.size, dir, turned);
    parallax_px = length(at - turned);
    found = there && share > 0.0 ? 1.0 : 0.0;
  }

  samples = min(samples, min(most_samples(moved_px), u.most_samples));
  vec4 value = before;
  // A picture that only turns keeps what it has: where samples are far apart, what none of them met is none the less there. What moves
  // against what is behind it may leave ghosts.
  float moving = smoothstep(kNoParallax_px, kMuchParallax_px, parallax_px);
  // This frame's samples around: their mean and spread, those before another surface left out.
  float step_px = length(vec2(u.step_x));
  vec4 mean = vec4(0.0), squares = vec4(0.0), filled = vec4(0.0);
  float weight = 0.0, fill_weight = 0.0;
  for (int i = 0; i < (moving > 0.0 || found == 0.0 ? 9 : 0); ++i) {
    ivec2 at = centre + (i % 3 - 1) * u.step_x + (i / 3 - 1) * u.step_y;
    if (any(lessThan(at, ivec2(0))) || any(greaterThan(at, last))) continue;
    vec4 seen = texelFetch(cloud_radiance, at, 0);
    float same = same_surface(at, surface_m) ? 1.0 : 0.0;
    vec2 off = vec2(at - pixel) / step_px;
    float near_px = exp(-0.5 * dot(off, off)), w = same * near_px;
    vec4 c = to_box_space(seen);
    mean += w * c;
    squares += w * c * c;
    weight += w;
    float near_by = same * max(1.0 - abs(off.x), 0.0) * max(1.0 - abs(off.y), 0.0) + 1.0e-4 * (w + 1.0e-3 * near_px);  // the last: where all are before another surface, as at the horizon
    filled += near_by * seen;
    fill_weight += near_by;
  }
  if (weight > 0.0 && moving > 0.0) {
    mean /= weight;
    vec4 spread = sqrt(max(squares / weight - mean * mean, vec4(0.0)));
    vec4 half_side = (kBoxSide * spread + vec4(vec3(kBoxLeast * mean.x + 1.0e-6), kBoxLeast)) / moving;
    vec4 history = to_box_space(before);
    float outside = outside_box(history, mean, half_side);
    if (outside > 1.0) {
      value = from_box_space(mean + (history - mean) / outside);
      samples = max(samples_left(samples, outside), 1.0);
    }
  }
  if (found == 0.0) {
    samples = 0.0;
    value = filled / max(fill_weight, 1.0e-12);
  }
  if (marched) {
    float w = new_weight(samples, dot(own.rgb, vec3(0.25, 0.5, 0.25)), dot(value.rgb, vec3(0.25, 0.5, 0.25)));
    value = mix(value, own, w);
    samples = min(samples + 1.0, kMostSamples);
  }
  value = vec4(max(value.rgb, vec3(0.0)), clamp(value.a, 0.0, 1.0));
  imageStore(out_radiance, pixel, value);
  imageStore(out_place, pixel, vec4(pack_history(info.x, samples), surface_m, 0.0, 0.0));
  float depth = value.a < 0.9999 ? min(info.x, closest_m) : kFarDepth_m;
  imageStore(out_info, pixel, marched ? info : vec4(depth, min(-log(max(value.a, 1.0e-7)), 16.0), depth > 0.5 * kFarDepth_m ? 0.0 : layer, 0.0));
}
