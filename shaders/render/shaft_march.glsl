// One ray for a block of pixels: what shade and haze change up to the nearest and the farthest surface of the block, and up to its clouds.
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 20) uniform sampler2D depth_m;
layout(set = 0, binding = 21) uniform sampler2D cloud_info;  // x: mean depth, m; z: layer, 0 without clouds
layout(set = 0, binding = 22, rgba32f) uniform writeonly image2D out_near;   // rgb change, a transmittance of the haze
layout(set = 0, binding = 23, rgba32f) uniform writeonly image2D out_far;
layout(set = 0, binding = 24, rgba32f) uniform writeonly image2D out_cloud;
layout(set = 0, binding = 25, rgba32f) uniform writeonly image2D out_depths;  // nearest, farthest, clouds' (0: none), m
layout(push_constant, scalar) uniform PushBlock { ShaftMarchPush push; };

void main() {
  FrameConstants f = frame.frame_data;
  ivec2 block = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(block * int(push.downscale), ivec2(f.size)))) return;
  vec3 depths = vec3(kFarDepth_m, 0.0, 0.0);
  float cloudy = 0.0;
  vec3 centre = vec3(0.0);  // of the farthest pixels: a ray to the sky must not meet the ground
  ivec2 first = block * int(push.downscale), last = min(first + int(push.downscale), ivec2(f.size));
  for (int y = first.y; y < last.y; ++y)
    for (int x = first.x; x < last.x; ++x) {
      float d = min(texelFetch(depth_m, ivec2(x, y), 0).r, kFarDepth_m);
      vec4 info = texelFetch(cloud_info, ivec2(x, y), 0);
      vec3 seen = vec3(float(x) + 0.5, float(y) + 0.5, 1.0);
      centre = d > 1.1 * depths.y ? seen : centre + (d > 0.9 * depths.y ? seen : vec3(0.0));
      depths.xy = vec2(min(depths.x, d), max(depths.y, d));
      bool cloud = push.has_clouds != 0u && info.z > 0.0;
      depths.z += cloud ? info.x : 0.0;
      cloudy += cloud ? 1.0 : 0.0;
    }
  depths.z /= max(cloudy, 1.0);
  AIR_BLOCK(block)
  vec3 dir = pixel_direction(f, centre.xy / centre.z);
  AirMarch m = start_air_march(dir);
  StepPlan plan;
  bool meets = shaft_stretch(m, max(depths.y, depths.z), plan);
  vec3 targets = vec3(depths.x, depths.y, depths.z);
  vec3 target_t = vec3(1.0);
  mat3 change = mat3(0.0), clear = mat3(0.0);
  if (meets) {
    if (HAZE > 0u) {
      vec3 unused;
      vec3 before = aerial_perspective(f, dir, plan.cut_m.x, 0.0, unused);
      for (int k = 0; k < 3; ++k) {
        target_t[k] = targets[k] > plan.cut_m.x ? exp(-haze_depth_to(m, min(targets[k], m.end_m))) : 1.0;
        clear[k] = before;
      }
    }
    // Rays of a 4 x 4 square of blocks take different points: their mean is that of 16 times as many.
    float shift = 0.5;
    if (push.jitter != 0u) {
      ivec2 q = block & 3;
      int order = ((q.x ^ q.y) & 1) * 8 + (q.y & 1) * 4 + (((q.x ^ q.y) >> 1) & 1) * 2 + ((q.y >> 1) & 1);
      shift = (float(order) + 0.5) / 16.0;
    }
    float t0 = plan.cut_m.x, depth0 = haze_depth_to(m, t0), haze0 = exp(-depth0);
    for (uint i = 0u; i < SHAFT_STEPS; ++i) {
      float t1 = step_distance(plan, float(i + 1u));
      float at = step_distance(plan, float(i) + shift);
      AirSource source = air_source_at(m, at, HAZE > 0u);
      float visible = max(1.0 - shafts.data.intensity * (1.0 - AIR_VISIBLE(dir * at)), 0.0);
      float depth1 = HAZE > 0u ? haze_depth_to(m, t1) : 0.0, haze1 = exp(-depth1);
      float haze = HAZE > 0u ? mean_transmittance(haze0, haze1, depth1 - depth0) : 1.0;
      float length_m = max(t1 - t0, 0.0);
      vec3 air = source.single * (visible * haze - 1.0) + source.multiple * (haze - 1.0);
      vec3 lit = source.haze * visible + source.haze_sky;
      for (int k = 0; k < 3; ++k) {
        float share_m = clamp(targets[k] - t0, 0.0, length_m);
        change[k] += share_m * air;
        if (HAZE > 0u) {
          change[k] += lit * max(haze0 - max(haze1, target_t[k]), 0.0);
          clear[k] += share_m * (source.single + source.multiple);
        }
      }
      t0 = t1;
      depth0 = depth1;
      haze0 = haze1;
    }
  }
  for (int k = 0; k < 3; ++k) change[k] += (1.0 - target_t[k]) * clear[k];
  imageStore(out_near, block, vec4(change[0], target_t[0]));
  imageStore(out_far, block, vec4(change[1], target_t[1]));
  imageStore(out_cloud, block, vec4(change[2], target_t[2]));
  imageStore(out_depths, block, vec4(depths, 0.0));
}
