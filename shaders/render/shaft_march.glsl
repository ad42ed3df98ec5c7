// Before it: AIR_LOOK(t, number): share of the key light, AIR_LOOKS times a step; AIR_VISIBLE(p_cam): once a step, times that; AIR_BLOCK(block) and
// AIR_RAY(dir): what these need.
//
// One ray for a block of pixels: what shade and haze change up to the nearest and the farthest surface of the block, and up to its nearest and
// farthest cloud.
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 20) uniform sampler2D depth_m;
layout(set = 0, binding = 21) uniform sampler2D cloud_depths;  // of clouds.march: the nearer and the farther one, m
layout(set = 0, binding = 22, rgba32f) uniform writeonly image2D out_near;   // rgb change, a transmittance of the haze
layout(set = 0, binding = 23, rgba32f) uniform writeonly image2D out_far;
layout(set = 0, binding = 24, rgba32f) uniform writeonly image2D out_cloud_near;
layout(set = 0, binding = 25, rgba32f) uniform writeonly image2D out_cloud_far;
layout(set = 0, binding = 27, rgba32f) uniform writeonly image2D out_depths;     // of the four, m; clouds' 0: there is none
layout(push_constant, scalar) uniform PushBlock { ShaftMarchPush push; };

const int kShadeLooks = AIR_LOOKS;  // for the sun, in a step

void main() {
  FrameConstants f = frame.frame_data;
  ivec2 block = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(block * ivec2(push.block), ivec2(f.size)))) return;
  vec4 depths = vec4(kFarDepth_m, 0.0, kFarDepth_m, 0.0);
  vec2 inner = vec2(0.0, kFarDepth_m);  // the farthest of the nearer ones of clouds, and the nearest of the farther ones
  vec3 centre = vec3(0.0);  // of the farthest pixels: a ray to the sky must not meet the ground
  ivec2 first = block * ivec2(push.block), last = min(first + ivec2(push.block), ivec2(f.size));
  for (int y = first.y; y < last.y; ++y)
    for (int x = first.x; x < last.x; ++x) {
      float d = min(texelFetch(depth_m, ivec2(x, y), 0).r, kFarDepth_m);
      vec2 cloud = texelFetch(cloud_depths, ivec2(x, y), 0).rg;
      vec3 seen = vec3(float(x) + 0.5, float(y) + 0.5, 1.0);
      centre = d > 1.1 * depths.y ? seen : centre + (d > 0.9 * depths.y ? seen : vec3(0.0));
      depths.xy = vec2(min(depths.x, d), max(depths.y, d));
      if (push.has_clouds != 0u && cloud.x < 0.5 * kFarDepth_m) {
        depths.zw = vec2(min(depths.z, cloud.x), max(depths.w, cloud.y));
        inner = vec2(max(inner.x, cloud.x), min(inner.y, cloud.y));
      }
    }
  depths.z = min(depths.z, depths.w);
  AIR_BLOCK(block)
  vec3 dir = pixel_direction(f, centre.xy / centre.z);
  AIR_RAY(dir)
  AirMarch m = start_air_march(dir);
  StepPlan plan;
  bool meets = shaft_stretch(m, max(depths.y, depths.w), plan);
  vec4 target_t = vec4(1.0);
  mat4x3 change = mat4x3(0.0), clear = mat4x3(0.0);
  if (meets) {
    if (HAZE > 0u) {
      vec3 unused;
      vec3 before = aerial_perspective(f, dir, plan.cut_m.x, 0.0, unused);
      for (int k = 0; k < 4; ++k) {
        target_t[k] = depths[k] > plan.cut_m.x ? exp(-haze_depth_to(m, min(depths[k], m.end_m))) : 1.0;
        clear[k] = before;
      }
    }
    // The ends of two steps move to the clouds, which may be sunlit behind and shaded before.
    vec2 cloud_m = 0.5 * (depths.zw + inner);
    float middle = step_distance(plan, 0.5);
    bool moved = false;
    float t0 = plan.cut_m.x, depth0 = haze_depth_to(m, t0), haze0 = exp(-depth0);
    // Clear air is looked at once in a group of steps. Loops, not branches: a software device runs both sides of these.
    AirStretch stretch = start_air_stretch(m, t0);
    int groups = int(plan.steps + 0.5) / kGroup;
    for (int j = 0; j < groups; ++j) {
      if (HAZE == 0u) next_air_stretch(m, stretch, step_distance(plan, float((j + 1) * kGroup)));
      for (int i = j * kGroup; i < (j + 1) * kGroup; ++i) {
        float t1 = step_distance(plan, float(i + 1)), at = middle;
        middle = step_distance(plan, float(i) + 1.5);
        bvec2 here = bvec2(cloud_m.x > at && cloud_m.x <= middle, cloud_m.y > at && cloud_m.y <= middle);
        bool move = any(here) && float(i + 1) < plan.steps - 0.5;
        if (move) t1 = all(here) ? 0.5 * (cloud_m.x + cloud_m.y) : here.x ? cloud_m.x : cloud_m.y;
        if (move || moved) at = 0.5 * (t0 + t1);
        moved = move;
        AirSource source = AirSource(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
        if (HAZE > 0u) source = air_source_at(m, at, true);
        else source.single = air_stretch_single(stretch, at);
        // Shade changes within a step where the air does not.
        float visible = 0.0;
        for (int l = 0; l < kShadeLooks; ++l) visible += AIR_LOOK(mix(t0, t1, (float(l) + 0.5) / float(kShadeLooks)), uint(i * kShadeLooks + l)) / float(kShadeLooks);
        visible = max(1.0 - shafts.data.intensity * (1.0 - visible * AIR_VISIBLE(dir * at)), 0.0);
        float depth1 = HAZE > 0u ? haze_depth_to(m, t1) : 0.0, haze1 = exp(-depth1);
        float haze = HAZE > 0u ? mean_transmittance(haze0, haze1, depth1 - depth0) : 1.0;
        float length_m = max(t1 - t0, 0.0);
        vec3 air = source.single * (visible * haze - 1.0) + source.multiple * (haze - 1.0);
        vec3 lit = source.haze * visible + source.haze_sky;
        for (int k = 0; k < 4; ++k) {
          float share_m = clamp(depths[k] - t0, 0.0, length_m);
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
  }
  for (int k = 0; k < 4; ++k) change[k] += (1.0 - target_t[k]) * clear[k];
#ifdef AIR_GLOW
  // The sun's glow over clouds: its own, of air and edges that scatter forwards, as far as it is open.
  vec3 glow = push.glow * screen_visible * f.key_illuminance * sun_transmittance(f.planet.camera_height_m, dot(f.camera_up, f.key_dir)) *
              phase_aerosol(atmosphere.air, m.ray.nu);
  change[2] += glow;
  change[3] += glow;
#endif
  imageStore(out_near, block, vec4(change[0], target_t[0]));
  imageStore(out_far, block, vec4(change[1], target_t[1]));
  imageStore(out_cloud_near, block, vec4(change[2], target_t[2]));
  imageStore(out_cloud_far, block, vec4(change[3], target_t[3]));
  imageStore(out_depths, block, depths);
}
