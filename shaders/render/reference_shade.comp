#version 460
#extension GL_GOOGLE_include_directive : require
// Gives the paths of a dispatch their air and their sky, and adds them to the pixels' sums.
#include "clouds/path_shared.h"
#include "common/frame.h"
#include "common/random.h"
#include "common/tonemap.h"
#include "render/reference_shared.h"
layout(local_size_x = 64) in;
layout(constant_id = 1) const bool FURNACE = false;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1) uniform sampler2D surface_emission;
layout(set = 0, binding = 2) uniform sampler2D background;
layout(scalar, set = 0, binding = 3) readonly buffer ResultBlock { PathResult at[]; } results;
layout(scalar, set = 0, binding = 4) buffer SumBlock { PixelSums at[]; } sums;
layout(scalar, set = 0, binding = 5) readonly buffer PlanBlock { PathPlan at[]; } plan;
#define ATMOSPHERE_BINDING 8
#include "atmosphere/atmosphere_lookup.glsl"
layout(push_constant, scalar) uniform PushBlock { ReferencePush push; };

// Light that comes in from space where a scattered path left.
vec3 sky_from(FrameConstants f, PathResult r) {
  vec3 up = unpack_direction(r.escape_up), dir = unpack_direction(r.escape_dir);
  float h = clamp(r.escape_height_m, 0.0, atmosphere.air.top_m);
  float mu = dot(up, dir);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < count_lights(f, dir.x); ++i) {
    vec3 light = light_dir(f, i);
    float nu = clamp(dot(dir, light), -1.0, 1.0);
    float length_m = distance_to_top(atmosphere.air, h, mu);
    ScatteredLight s = scatter_along(h, mu, dot(up, light), nu, length_m, length_m, phase_rayleigh(nu), 1.0);
    sum += (s.smooth_part + s.mie * phase_aerosol(atmosphere.air, nu)) * light_factor(f, i);
  }
  return sum + f.night_illuminance / kPi;
}

void main() {
  uint pixel = gl_GlobalInvocationID.x;
  if (pixel >= push.pixels) return;
  FrameConstants f = frame.frame_data;
  PixelSums sum = sums.at[pixel];
  PathPlan mine = plan.at[pixel];
  uint samples = plan.at[pixel + 1u].first_item - mine.first_item;
  for (uint k = 0u; k < samples; ++k) {
    PathResult r = results.at[mine.first_item + k];
    // The very place in the pixel where the path began.
    Random random = random_stream(pixel, mine.first_sample + k, push.seed);
    float u = random_unit(random);
    vec2 at = (vec2(float(pixel % push.width), float(pixel / push.width)) + vec2(u, random_unit(random))) * float(push.subpixels);
    ivec2 sub = min(ivec2(at), ivec2(f.size) - 1);
    vec3 dir = pixel_direction(f, at);
    bool sky = r.kind == kPathSky, cloud = r.kind >= kPathCloud;
    vec3 light = r.sunlit;
    float seen = 0.0;
    if (FURNACE) {
      light += r.weight * push.furnace_cd_m2;
      if (sky) seen = r.weight.x;
    } else {
      bool left = any(notEqual(r.weight, vec3(0.0)));
      if (sky) {
        light += r.weight * texelFetch(background, sub, 0).rgb;
      } else {
        if (left) light += r.weight * sky_from(f, r);
        if (!cloud) light += r.first_weight * push.night_light_cd_m2 * texelFetch(surface_emission, sub, 0).rgb;
        vec3 through;
        vec3 air = aerial_perspective(f, dir, r.first_m, 0.0, through);
        light = light * through + air * r.first_weight;
      }
      seen = cloud ? 0.0 : sky ? r.weight.x : r.first_weight;
    }
    sum.paths += 1.0;
    float share = 1.0 / sum.paths;
    vec3 before = light - sum.mean;
    sum.mean += before * share;
    sum.squares += before * (light - sum.mean);
    sum.y_squares += luminance(before) * luminance(light - sum.mean);
    sum.cloud += ((cloud ? light : vec3(0.0)) - sum.cloud) * share;
    sum.transmittance += (seen - sum.transmittance) * share;
    if (cloud) {
      sum.depth_m += r.first_m;
      sum.layers[r.kind - kPathCloud] += 1.0;
    }
  }
  sums.at[pixel] = sum;
}
