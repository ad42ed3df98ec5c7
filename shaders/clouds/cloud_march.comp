#version 460
#extension GL_GOOGLE_include_directive : require
// Marches one cloud layer between its two shells for every pixel. Writes what the clouds send to the eye as shares of the lights
// (cloud_shade.comp makes luminance of them) and their transmittance; and depth, optical depth, layer and step count.
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_light.glsl"
layout(set = 0, binding = 20, r32f) uniform readonly image2D depth_m;
layout(set = 0, binding = 21, rgba32f) uniform writeonly image2D out_light;
layout(set = 0, binding = 22, rgba32f) uniform writeonly image2D out_info;

const int kMaxSteps = 176;
const int kCovers = 8;             // readings of the weather map along a ray
const int kMaxLights = 6;           // points of a ray that look for the sun
const float kLightShare = 0.20;     // about how much of what the ray sees each stands for
const float kOpaque = 1.0e-3;       // transmittance at which nothing behind matters
const float kDeepest = 8.0;        // optical depth at which the wide lobes are used up too
const float kLevelStep_m = 400.0;   // a level of -1 is about this far from a cloud, at least
const float kColumn_m = 250.0;      // ground between two readings of the slow fields
const float kSkyView = 0.3;         // as CloudOctave.view, for light of the sky and the ground
const float kShapeReach = 0.60;     // most that billows add to a level, but for rare peaks

// Interleaved gradient noise (Jimenez 2014), another offset each frame.
float march_jitter(uvec2 pixel) {
  uint shift = (frame.frame_data.frame_index * 7u + frame.frame_data.seed * 13u) % 256u;
  vec2 p = vec2(pixel) + 5.588238 * float(shift);
  return fract(52.9829189 * fract(dot(p, vec2(0.06711056, 0.00583715))));
}

// The stretches of the ray inside the layer: [span.x, span.y] without the part [gap.x, gap.y] below it. entry_f_m2 is
// planet_f() at span.x, known from the shell itself where the ray enters through one: no large float is subtracted.
bool layer_span(vec3 dir, float far_m, out vec2 span, out vec2 gap, out float entry_f_m2) {
  PlanetView planet = frame.frame_data.planet;
  // Scaled height is up to 1.00336 times the geodetic one: the shells are taken that much apart.
  float low_m = CLOUD.base_m - 0.03 * CLOUD.thickness_m, high_m = (CLOUD.base_m + CLOUD.thickness_m) * 1.0034;
  gap = vec2(kFarDepth_m);
  entry_f_m2 = planet.camera_f_m2;
  vec2 outer, inner;
  if (!intersect_shell(planet, dir, high_m, outer) || outer.y <= 0.0) return false;
  span = vec2(max(outer.x, 0.0), min(outer.y, far_m));
  if (outer.x > 0.0) entry_f_m2 = high_m * (2.0 * planet.a_m + high_m);
  if (intersect_shell(planet, dir, low_m, inner) && inner.y > 0.0) {
    if (inner.x <= 0.0) {  // the camera is below the layer
      span.x = inner.y;
      entry_f_m2 = low_m * (2.0 * planet.a_m + low_m);
    } else {
      gap = inner;
    }
  }
  return span.x < span.y;
}

void main() {
  // Neighbouring lanes march in step: blocks of 4 x 2 pixels stay together better than rows of 8.
  uint l = gl_LocalInvocationIndex;
  ivec2 pixel = ivec2(gl_WorkGroupID.xy * 8u + uvec2((l & 3u) | ((l >> 1) & 4u), ((l >> 2) & 1u) | ((l >> 3) & 6u)));
  if (any(greaterThanEqual(pixel, ivec2(frame.frame_data.size)))) return;
  PlanetView planet = frame.frame_data.planet;
  vec3 dir = pixel_direction(frame.frame_data, vec2(pixel) + 0.5);
  vec3 sun = frame.frame_data.key_dir;

  vec2 span, gap;
  float entry_f_m2;
  float transmittance = 1.0, depth_sum = 0.0, weight_sum = 0.0, tau = 0.0;
  vec3 light = vec3(0.0);  // share of sun illuminance, of sky illuminance, of ground exitance (1/sr)
  int steps = 0;
  if (layer_span(dir, imageLoad(depth_m, pixel).r, span, gap, entry_f_m2)) {
    float cos_sun = dot(dir, sun);
    float phase = phase_dual_hg(cos_sun, CLOUD.phase_g_forward, CLOUD.phase_g_backward, CLOUD.phase_backward_weight);
    vec2 lobes = vec2(0.0);
    for (int n = 0; n < 2; ++n) lobes[n] = kOctaves[n].gain * phase_hg(cos_sun, CLOUD.phase_g_forward * kOctaves[n].lobe);

    vec3 scaled_dir = scaled_from_cam(planet, dir);
    vec3 entry_q = planet.camera_q_m + scaled_dir * span.x;
    float f_slope = 2.0 * dot(entry_q, scaled_dir), f_bend = dot(scaled_dir, scaled_dir);
    float longest = min(span.y, gap.x) - span.x;
    if (gap.x < span.y) longest = max(longest, span.y - gap.y);
    float coarse = smoothstep(80.0, 500.0, frame.frame_data.pixel_angle_rad * span.x);
    float cap = max(longest / (CLOUD.uniform_density > 0.0 ? 160.0 : mix(24.0, 12.0, coarse)), 10.0), leap = 0.12 * longest;
    float jitter = mix(0.7 * march_jitter(uvec2(pixel)), 0.5, coarse);  // from far away the field is smooth: no noise wanted
    float s = 0.0, end = span.y - span.x;  // along the ray from its entry: exact from any distance
    vec2 gap_s = gap - span.x;
    CloudColumn near = CloudColumn(0.0, 0.0, 0.0, vec2(0.0)), far = near;
    float near_t = span.x - 1.0, far_t = span.x - 1.0, column_m = 0.0;
    vec4 sources[kMaxLights], columns[kMaxLights];
    float bends[kMaxLights];
    vec4 pending = vec4(0.0);
    float pending_seen = 0.0;
    int lights = 0;
    float light_share = mix(kLightShare, 0.45, coarse);
    vec3 wide = vec3(0.0);  // optical depths so far of the two wide lobes and of sky light
    // Coverage at distances that grow as squares: read here, where all rays of a group read together. (A software device pays
    // for everything within the march's loop at every step, whether a condition asks for it or not.)
    float covers[kCovers];
    for (int i = 0; i < kCovers; ++i) {
      float u = float(i) / float(kCovers - 1);
      float cover_t = span.x + end * u * u;
      covers[i] = cloud_probit(dir * cover_t, log2(max(frame.frame_data.pixel_angle_rad * cover_t, 1.0)));
    }
    for (; steps < kMaxSteps && s < end; ++steps) {
      if (s >= gap_s.x && s < gap_s.y) s = gap_s.y;
      if (s >= end) break;
      float t = span.x + s;
      float fine = min(max(t * 0.02, 36.0), cap);
      float at_s = min(s + jitter * fine, end);  // stretches of the ray tile it exactly; each is sampled somewhere inside
      float at = span.x + at_s;
      vec3 q = entry_q + scaled_dir * at_s;
      vec3 sq = vec3(q.xy, q.z * planet.a_over_b);
      float inv = inversesqrt(dot(sq, sq));
      vec3 up = sq * inv;
      float height_m = scaled_height_from_f(planet, entry_f_m2 + at_s * (f_slope + at_s * f_bend)) * length(q) * inv;
      float eta = (height_m - CLOUD.base_m) / CLOUD.thickness_m;
      vec3 p = dir * at;

      float footprint_m = max(frame.frame_data.pixel_angle_rad * at, 0.08 * fine);
      float log2_footprint = log2(footprint_m);
      float step_m = fine, sigma = 0.0, level = 0.0, clump_depth = 0.0, unresolved = 0.0;
      CloudColumn column;
      if (CLOUD.uniform_density > 0.0) {
        if (eta >= 0.0 && eta <= 1.0) sigma = CLOUD.uniform_density * CLOUD.extinction_per_m;
        level = 1.0;
        column = CloudColumn(8.0, 0.0, 0.0, vec2(0.0));
      } else if (eta > -0.03 && eta < 1.0) {
        // Slow fields: read every few hundred metres of ground, straight lines between.
        while (far_t < at) {
          near = far;
          near_t = far_t;
          far_t = max(far_t + column_m, at);
          vec3 far_p = dir * far_t;
          float far_footprint_m = frame.frame_data.pixel_angle_rad * far_t;
          float place = sqrt(clamp((far_t - span.x) / end, 0.0, 1.0)) * float(kCovers - 1);
          int first = min(int(place), kCovers - 2);
          far = cloud_column_with(mix(covers[first], covers[first + 1], place - float(first)), far_p, geodetic_up(planet, far_p),
                                  geodetic_height(planet, far_p), log2(max(far_footprint_m, 1.0)));
          column_m = max(kColumn_m, 2.0 * far_footprint_m) / max(sqrt(max(1.0 - pow(dot(dir, up), 2.0), 0.0)), 0.05);
        }
        column = mix_columns(near, far, (at - near_t) / max(far_t - near_t, 1.0e-3));
        float unknown = column.unknown;
        level = cloud_cell_level(column, p, up, height_m, eta, log2_footprint, unknown);
        // (the steep cut below the base says nothing about distance)
        float reach = level + kBaseSharpness * max(0.05 - eta, 0.0) + kShapeReach * CLOUD.shape_amount * smoothstep(0.0, 0.25, eta) + 2.6 * sqrt(unknown);
        if (reach > 0.0) {
          level += cloud_shape_level(p, eta, log2_footprint, unknown);
          if (abs(level) < 0.3 && transmittance > 0.1) level += cloud_detail_level(p, eta, log2_footprint, unknown);
          CloudMedium medium = cloud_medium(level, unknown, fine * 0.0006, eta, footprint_m);
          sigma = medium.sigma_per_m;
          clump_depth = medium.clump_depth;
          unresolved = clamp(3.0 * unknown, 0.0, 1.0);
          if (sigma > 0.0)
            step_m = tau < 4.0 ? clamp(1.0 / sigma, 0.4 * fine, fine) : 3.0 * fine;  // about one optical depth
          else
            step_m = clamp(-level * kLevelStep_m, fine, min(4.0 * fine, leap));
        } else {
          step_m = clamp(-reach * kLevelStep_m, fine, min(fine + 0.08 * t + 200.0, leap));
        }
      }

      if (sigma > 0.0) {
        step_m = min(step_m, (s < gap_s.x ? min(end, gap_s.x) : end) - s);
        float d_tau = sigma * step_m;
        float w = transmittance * (1.0 - exp(-d_tau));
        // Deep in a cloud light comes from all around; at its rim from one side.
        float fill = mix(mix(0.5, 1.0, clamp(level * 1.8, 0.0, 1.0)), 0.85, unresolved);
        // Scaled by `view` inside a clump; a clump as a whole hides what lies behind for every order alike.
        vec3 scale = vec3(kOctaves[0].view, kOctaves[1].view, kSkyView);
        float x = max(clump_depth, 0.02);
        vec3 d_wide = d_tau * (1.0 - exp(-scale * x)) / (1.0 - exp(-x));
        vec3 w_wide = exp(-wide) * (1.0 - exp(-d_wide));
        wide += d_wide;
        // Sunlight waits for its shadow: what this stretch sends, by how fast each part fades with the depth to the sun.
        vec3 sent = vec3(w * phase, w_wide.xy * lobes * fill);
        float seen = w + 0.5 * (w_wide.x + w_wide.y);
        pending += vec4(at * seen, sent);
        pending_seen += seen;
        if (pending_seen > light_share && lights < kMaxLights) {
          sources[lights] = vec4(pending.x / pending_seen, pending.yzw);
          columns[lights] = vec4(column.probit, column.slow, column.unknown, column.bend.x);
          bends[lights] = column.bend.y;
          ++lights;
          pending = vec4(0.0);
          pending_seen = 0.0;
        }
        float w_sky = w_wide.z;
        float h = clamp(eta, 0.0, 1.0);
        light += vec3(0.0, w_sky * mix(0.16, 0.55, h) / kPi, w_sky * mix(0.45, 0.1, h) / kPi);
        depth_sum += w * at;
        weight_sum += w;
        tau += d_tau;
        transmittance *= exp(-d_tau);
        if (tau > kDeepest) break;
      }
      s += step_m;
    }
    // What is left goes with the last source; or is the only one, where the ray sees little.
    if (pending_seen > 0.0) {
      if (lights == 0) {
        sources[0] = vec4(pending.x / pending_seen, pending.yzw);
        columns[0] = vec4(near.probit, near.slow, near.unknown, near.bend.x);
        bends[0] = near.bend.y;
        lights = 1;
      } else {
        sources[lights - 1].yzw += pending.yzw;
      }
    }
    // All lanes march towards the sun together here; within the loop above each step of one would have cost them all.
    for (int i = 0; i < lights; ++i) {
      float at = sources[i].x;
      float at_s = at - span.x;
      vec3 q = entry_q + scaled_dir * at_s;
      vec3 sq = vec3(q.xy, q.z * planet.a_over_b);
      float inv = inversesqrt(dot(sq, sq));
      float height_m = scaled_height_from_f(planet, entry_f_m2 + at_s * (f_slope + at_s * f_bend)) * length(q) * inv;
      CloudColumn column = CloudColumn(columns[i].x, columns[i].y, columns[i].z, vec2(columns[i].w, bends[i]));
      float footprint_m = max(frame.frame_data.pixel_angle_rad * at, 0.08 * min(max(at * 0.013, 27.0), cap));
      float sun_depth = cloud_sun_depth(dir * at, sq * inv, height_m, column, log2(footprint_m));
      light.x += dot(sources[i].yzw, exp(-sun_depth * vec3(1.0, kOctaves[0].sun, kOctaves[1].sun)));
    }
    if (transmittance < kOpaque) transmittance = 0.0;
  }

  float mean_m = weight_sum > 0.0 ? depth_sum / weight_sum : kFarDepth_m;
  imageStore(out_light, pixel, vec4(light, transmittance));
  imageStore(out_info, pixel, vec4(mean_m, tau, weight_sum > 0.0 ? 1.0 : 0.0, float(steps)));
}
