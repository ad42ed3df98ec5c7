#version 460
#extension GL_GOOGLE_include_directive : require
// Averages each cell of light with those around it that are near in space: where cells are finer than light varies their paths
// are shared.
#include "common/frame.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_PLANET frame.frame_data.planet
layout(set = 0, binding = 6) uniform sampler3D grid_tex;
layout(set = 0, binding = 7) uniform sampler3D most_tex;
#include "clouds/cloud_grid.glsl"
#include "clouds/light_cells.glsl"
layout(scalar, set = 0, binding = 1) uniform LightBlock { CloudLightConstants data; } light;
layout(scalar, set = 0, binding = 2) readonly buffer WorkBlock { LightWork data; } work;
layout(scalar, set = 0, binding = 3) readonly buffer ListBlock { uint at[]; } list;
layout(set = 0, binding = 4) uniform sampler3D in_cells;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image3D out_cells;

layout(push_constant, scalar) uniform PushBlock { int stride; } push;  // of the cells that are averaged

void main() {
  uint item = gl_GlobalInvocationID.x;
  if (item >= work.data.count) return;
  LightCells cells = light.data.cells;
  uint cell = list.at[item];
  ivec3 size = ivec3(cells.nodes, cells.slices);
  ivec3 at = ivec3(int((cell / cells.slices) % cells.nodes.x), int(cell / cells.slices / cells.nodes.x), int(cell % cells.slices));
  FrameConstants f = frame.frame_data;
  CloudGrid grid = light.data.grid;
  vec3 dir = light_node_direction(f, cells, uvec2(at.xy));
  float entry = max(light_entry(f.planet, grid, dir), 0.0);
  float s = light_slice_m(cells, float(at.z) + 0.5), slice_m = s * cells.growth + cells.first_m;
  vec2 across_m = (entry + s) * 2.0 * vec2(length(f.right), length(f.up)) / vec2(cells.nodes);
  Place here = place_on(flight_from(dir * (entry + s), dir));
  float above_m, below_m;
  int band = grid_band(grid, here.height_m, above_m, below_m);
  float sigma_per_m = band >= 0 ? (1.0 - light.data.forward_albedo) * grid_read(grid, band, here).x : 0.0;
  vec3 spread = float(push.stride) * vec3(across_m, slice_m) / min(cells.smooth_m, cells.smooth_paths / max(sigma_per_m, 1.0e-6));
  vec3 side = exp(-0.5 * spread * spread);  // weights of the next cells along each axis
  vec4 sum = vec4(0.0);
  for (int n = 0; n < 27; ++n) {
    ivec3 d = ivec3(n % 3, (n / 3) % 3, n / 9) - 1;
    ivec3 there = at + push.stride * d;
    vec3 w = mix(vec3(1.0), side, abs(vec3(d)));
    if (all(greaterThanEqual(there, ivec3(0))) && all(lessThan(there, size))) {
      vec4 cell = texelFetch(in_cells, there, 0);
      sum += (w.x * w.y * w.z) * vec4(cell.rgb * cell.a, cell.a);  // by numbers of paths
    }
  }
  imageStore(out_cells, at, sum.a > 0.0 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0));
}
