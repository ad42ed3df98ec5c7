// One column of the frustum grid: shade and haze summed from slice to slice. Each texel holds what lies before the far side of its slice.
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 20, rgba32f) uniform writeonly image3D out_change;         // rgb change, a transmittance of the haze
layout(set = 0, binding = 21, rgba32f) uniform writeonly image3D out_light;          // luminance of the air, shaded and hazy
layout(set = 0, binding = 22, rgba32f) uniform writeonly image3D out_transmittance;  // of air and haze
layout(push_constant, scalar) uniform PushBlock { FroxelGrid grid; } push;
layout(constant_id = 8) const bool LIGHT = false;  // the last two are wanted
const uint kSamples = 2u;  // of a slice

void main() {
  FrameConstants f = frame.frame_data;
  uvec2 cell = gl_GlobalInvocationID.xy;
  if (any(greaterThanEqual(cell, push.grid.size.xy))) return;
  vec3 dir = pixel_direction(f, (vec2(cell) + 0.5) / vec2(push.grid.size.xy) * vec2(f.size));
  AirMarch m = start_air_march(dir);
  float end_m = m.ray.in_air ? m.end_m : 0.0;
  float t0 = min(max(push.grid.start_m, m.ray.start_m), end_m), depth0 = haze_depth_to(m, t0), haze0 = exp(-depth0);
  vec3 change = vec3(0.0), clear = vec3(0.0), light = vec3(0.0), unused;
  if (HAZE > 0u || LIGHT) clear = light = aerial_perspective(f, dir, t0, 0.0, unused);
  for (uint k = 0u; k < push.grid.size.z; ++k) {
    for (uint j = 0u; j < kSamples; ++j) {
      float x = float(k) + float(j + 1u) / float(kSamples);
      float t1 = clamp(froxel_distance(push.grid, x), t0, max(end_m, t0));
      float at = 0.5 * (t0 + t1), length_m = t1 - t0;
      AirSource source = air_source_at(m, at, HAZE > 0u || LIGHT);
      float visible = max(1.0 - shafts.data.intensity * (1.0 - AIR_VISIBLE(dir * at)), 0.0);
      float depth1 = HAZE > 0u ? haze_depth_to(m, t1) : 0.0, haze1 = exp(-depth1);
      float haze = HAZE > 0u ? mean_transmittance(haze0, haze1, depth1 - depth0) : 1.0;
      vec3 lit = (source.haze * visible + source.haze_sky) * (haze0 - haze1);
      change += length_m * (source.single * (visible * haze - 1.0) + source.multiple * (haze - 1.0)) + lit;
      clear += length_m * (source.single + source.multiple);
      light += length_m * haze * (source.single * visible + source.multiple) + lit;
      t0 = t1;
      depth0 = depth1;
      haze0 = haze1;
    }
    ivec3 texel = ivec3(cell, k);
    imageStore(out_change, texel, vec4(HAZE > 0u ? change + (1.0 - haze0) * clear : change, haze0));
    if (LIGHT) {
      vec3 columns = vec3(0.0);
      float length_m = max(t0 - m.ray.start_m, 0.0) * m.ray.stretch;
      float h = height_along(atmosphere.air, m.ray.h, m.ray.mu, length_m);
      float mu = clamp(((atmosphere.air.radius_m + m.ray.h) * m.ray.mu + length_m) / (atmosphere.air.radius_m + h), -1.0, 1.0);
      if (m.ray.in_air) columns = columns_along(m.path, mu, sampled_columns_to_top(atmosphere.air, h, abs(mu)));
      imageStore(out_light, texel, vec4(light, 1.0));
      imageStore(out_transmittance, texel, vec4(transmittance_of(columns) * haze0, 1.0));
    }
  }
}
