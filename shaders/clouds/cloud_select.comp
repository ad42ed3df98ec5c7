#version 460
#extension GL_GOOGLE_include_directive : require
// Which pixels of an upscaled picture are marched this frame: those of the frame's pattern, and all that the last frame says nothing
// about. The others get what was seen there as their depth, for passes that look at their neighbours.
#include "common/frame.h"
#include "clouds/upscale_shared.h"
layout(local_size_x = 16, local_size_y = 16) in;
layout(constant_id = 1) const bool FILL = false;  // out_radiance too
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(scalar, set = 0, binding = 1) uniform UpscaleBlock { UpscaleConstants data; } upscale;
layout(set = 0, binding = 2) uniform sampler2D depth_m;
layout(set = 0, binding = 3) uniform sampler2D last_radiance;  // of the clouds: premultiplied; transmittance
layout(set = 0, binding = 4) uniform sampler2D last_place;     // clouds' depth and number of samples; surface's depth
layout(scalar, set = 0, binding = 5) writeonly buffer PixelListBlock { uint at[]; } pixel_list;
layout(scalar, set = 0, binding = 6) buffer Groups64Block { uvec4 count; } groups_64;
layout(scalar, set = 0, binding = 7) buffer Groups256Block { uvec4 count; } groups_256;
layout(set = 0, binding = 8, rgba32f) uniform writeonly image2D out_info;
layout(set = 0, binding = 9, rg32f) uniform writeonly image2D out_depths;
layout(set = 0, binding = 10, rgba32f) uniform writeonly image2D out_radiance;
#include "clouds/upscale_history.glsl"
shared uint listed, first;

void main() {
  FrameConstants f = frame.frame_data;
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  bool inside = all(lessThan(pixel, ivec2(f.size)));
  if (gl_LocalInvocationIndex == 0u) listed = 0u;
  barrier();
  bool march = false;
  float cloud_m = kFarDepth_m;
  ivec2 from = clamp(pixel, ivec2(0), ivec2(f.size) - 1);
  if (inside) {
    march = in_pattern(upscale.data, pixel);
    float surface_m = min(texelFetch(depth_m, pixel, 0).r, kFarDepth_m);
    bool known = true;
    vec2 place = texelFetch(last_place, from, 0).rg;
    if (upscale.data.still == 0u) {
      // Where the camera's turn alone would have put it; then where the depth of the cloud that was there says.
      vec3 dir = pixel_direction(f, vec2(pixel) + 0.5 - f.jitter_px);
      vec2 at, again;
      known = previous_pixel(upscale.data, f.size, dir, at);
      float guess_m = history_depth(texelFetch(last_place, history_texel(at), 0).r);
      known = known && previous_pixel(upscale.data, f.size, dir * guess_m + shift_of(guess_m), at);
      known = known && all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(f.size)));
      from = history_texel(at);
      place = texelFetch(last_place, from, 0).rg;
      float found_m = history_depth(place.r);
      // Another depth there, which would have been seen elsewhere: an edge that moved against what is behind it.
      known = known && previous_pixel(upscale.data, f.size, dir * found_m + shift_of(found_m), again);
      vec2 off = again - at;
      known = known && dot(off, off) < kStraySplit_px * kStraySplit_px;
      float way_m = length(upscale.data.shift_m);
      known = known && way_m < kMostParallax * found_m;
      cloud_m = found_m > 0.5 * kFarDepth_m ? kFarDepth_m : max(found_m - dot(dir, upscale.data.shift_m), 1.0);
      known = known && any(greaterThan(history_fits(at, length(dir * surface_m + shift_of(surface_m)), found_m), vec4(0.0)));
    } else {
      cloud_m = history_depth(place.r);
      known = surface_fits(surface_m, place, pixel);
    }
    known = known && history_samples(place.r) > 0u;
    march = march || !known;
  }
  uint index = 0u;
  if (march) index = atomicAdd(listed, 1u);
  barrier();
  if (gl_LocalInvocationIndex == 0u && listed > 0u) {
    first = atomicAdd(groups_64.count.w, listed);
    uint end = first + listed;
    atomicAdd(groups_256.count.w, listed);
    atomicMax(groups_64.count.x, (end + 63u) / 64u);
    atomicMax(groups_256.count.x, (end + 255u) / 256u);
    atomicMax(groups_64.count.y, 1u);
    atomicMax(groups_64.count.z, 1u);
    atomicMax(groups_256.count.y, 1u);
    atomicMax(groups_256.count.z, 1u);
  }
  barrier();
  if (march) {
    pixel_list.at[first + index] = uint(pixel.x) | (uint(pixel.y) << 16);
  } else if (inside) {
    imageStore(out_info, pixel, vec4(cloud_m, 0.0, 0.0, -1.0));  // -1 steps: not marched
    imageStore(out_depths, pixel, vec4(cloud_m, cloud_m, 0.0, 0.0));
    if (FILL) imageStore(out_radiance, pixel, texelFetch(last_radiance, from, 0));
  }
}
