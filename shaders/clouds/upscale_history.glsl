// Reading the last frame's clouds. Needs `frame`, `upscale`, `last_place` and `last_radiance` declared before it.

// Clouds' depth and the number of samples share a float: the number is in the lowest seven bits.
float pack_history(float cloud_m, float samples) { return uintBitsToFloat((floatBitsToUint(cloud_m) & ~127u) | uint(clamp(samples + 0.5, 0.0, 127.0))); }
float history_depth(float packed) {
  float cloud_m = uintBitsToFloat(floatBitsToUint(packed) & ~127u);
  return cloud_m > 0.5 * kFarDepth_m || cloud_m <= 0.0 ? kFarDepth_m : cloud_m;
}
uint history_samples(float packed) { return floatBitsToUint(packed) & 127u; }

ivec2 history_texel(vec2 at_px) { return clamp(ivec2(floor(at_px)), ivec2(0), ivec2(frame.frame_data.size) - 1); }

// What the clear sky is at has no depth: only the camera's turn moves it.
vec3 shift_of(float distance_m) { return distance_m > 0.5 * kFarDepth_m ? vec3(0.0) : upscale.data.shift_m; }

// Whether clouds that were seen before a surface (or none) at place.y are what is to be seen before one at surface_m: as far as clouds go
// both are as far; or an opaque cloud hides which; or there were none, and now the ray is shorter.
bool surface_fits(float surface_m, vec2 place, ivec2 texel) {
  float seen_m = place.y;
  bool fits = abs(surface_m - seen_m) <= kNearlySame * min(surface_m, seen_m);
  // A loop where an `if` would do: a software device skips it when no lane wants it, and would pay for a branch that none takes.
  for (int i = 0; i < (fits ? 0 : 1); ++i) {
    float through = texelFetch(last_radiance, texel, 0).a;
    fits = seen_m > surface_m ? through > 0.999 : through < 0.001 && history_depth(place.x) < seen_m;
  }
  return fits;
}

// Shares of the four texels around a place in the last frame (x, x + 1; next row) that history may come from; 0 where a surface in front
// came or went.
vec4 history_fits(vec2 at_px, float surface_m, float cloud_m) {
  vec2 at = at_px - 0.5;
  ivec2 low = ivec2(floor(at)), last = ivec2(frame.frame_data.size) - 1;
  vec2 part = at - vec2(low);
  vec4 weights = vec4((1.0 - part.x) * (1.0 - part.y), part.x * (1.0 - part.y), (1.0 - part.x) * part.y, part.x * part.y);
  for (int i = 0; i < 4; ++i) {
    ivec2 texel = clamp(low + ivec2(i & 1, i >> 1), ivec2(0), last);
    vec2 place = texelFetch(last_place, texel, 0).rg;
    if (history_samples(place.x) == 0u || !surface_fits(surface_m, place, texel)) weights[i] = 0.0;
  }
  return weights;
}
