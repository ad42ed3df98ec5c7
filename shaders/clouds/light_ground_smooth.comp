#version 460
#extension GL_GOOGLE_include_directive : require
// Averages the light that clouds send to the ground over nodes whose places are near each other: seen from far below, clouds
// light neighbouring places alike, and nodes share their paths.
#include "common/frame.h"
#include "clouds/light_nodes.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(scalar, set = 0, binding = 1) uniform LightBlock { CloudLightConstants data; } light;
layout(set = 0, binding = 2) uniform sampler2D in_ground;  // of light_gather.comp
layout(set = 0, binding = 3, rgba32f) uniform writeonly image2D out_ground;
layout(set = 0, binding = 4) uniform sampler2D in_weight;  // in full sets of paths

const int kReach = 8;               // nodes

void main() {
  FrameConstants f = frame.frame_data;
  LightCells cells = light.data.cells;
  ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = ivec2(cells.nodes);
  if (any(greaterThanEqual(at, size))) return;
  vec4 here = texelFetch(in_ground, at, 0);
  if (here.a >= 0.5 * kFarDepth_m) {  // the sky
    imageStore(out_ground, at, here);
    return;
  }
  vec2 pixels = vec2(f.size) / vec2(cells.nodes);
  vec3 p = pixel_direction(f, (vec2(at) + 0.5) * pixels) * here.a;
  float radius_m = light_ground_radius_m(f.planet, light.data.grid, p);
  vec4 sum = vec4(0.0);
  for (int y = -kReach; y <= kReach; ++y)
    for (int x = -kReach; x <= kReach; ++x) {
      ivec2 there = at + ivec2(x, y);
      if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, size))) continue;
      vec4 other = texelFetch(in_ground, there, 0);
      vec3 apart = pixel_direction(f, (vec2(there) + 0.5) * pixels) * other.a - p;
      float w = exp(-0.5 * dot(apart, apart) / (radius_m * radius_m)) * texelFetch(in_weight, there, 0).r;
      if (other.a < 0.5 * kFarDepth_m) sum += vec4(w * other.rgb, w);
    }
  imageStore(out_ground, at, vec4(sum.rgb / max(sum.a, 1.0e-6), here.a));
}
