#version 460
#extension GL_GOOGLE_include_directive : require
// Which cells of light are seen: rays through every few pixels march the density grid and mark the nodes around what they meet.
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_PLANET frame.frame_data.planet
layout(set = 0, binding = 1) uniform sampler3D grid_tex;
layout(set = 0, binding = 5) uniform sampler3D most_tex;
#include "clouds/cloud_grid.glsl"
#include "clouds/light_cells.glsl"
layout(scalar, set = 0, binding = 2) uniform LightBlock { CloudLightConstants data; } light;
layout(scalar, set = 0, binding = 3) buffer MarkBlock { uint at[]; } marks;
layout(set = 0, binding = 4) uniform sampler2D depth_m;

const float kThinnest = 1.0e-6;  // 1/m

void main() {
  FrameConstants f = frame.frame_data;
  LightCells cells = light.data.cells;
  CloudGrid grid = light.data.grid;
  uvec2 pixel = gl_GlobalInvocationID.xy * cells.stride_px + cells.stride_px / 2u;
  if (any(greaterThanEqual(pixel, f.size))) return;
  vec3 dir = pixel_direction(f, vec2(pixel) + 0.5);
  float entry = light_entry(f.planet, grid, dir);
  if (entry < 0.0) return;
  float end = texelFetch(depth_m, ivec2(pixel), 0).r;
  Flight flight = flight_from(vec3(0.0), dir);
  vec2 node = (vec2(pixel) + 0.5) * vec2(cells.nodes) / vec2(f.size) - 0.5;
  ivec2 low = clamp(ivec2(floor(node)), ivec2(0), ivec2(cells.nodes) - 1), high = min(low + 1, ivec2(cells.nodes) - 1);
  float tau = 0.0;
  bool before = false;
  uint words = cells.slices / 32u;
  for (uint i = 0u; i < cells.slices; ++i) {
    float from = light_slice_m(cells, float(i)), to = light_slice_m(cells, float(i) + 1.0);
    flight.s = entry + 0.5 * (from + to);
    if (entry + from > end || tau > cells.deepest) break;
    Place here = place_on(flight);
    float above_m, below_m;
    int band = grid_band(grid, here.height_m, above_m, below_m);
    if (band < 0 && below_m >= kFar_m && dot(here.up, dir) > 0.0 && above_m >= kFar_m) break;
    float sigma = band >= 0 ? grid_read(grid, band, here).x : 0.0;
    if (band < 0 && min(above_m, below_m) < to - from) sigma = 2.0 * kThinnest;  // a band's rim may be in this slice
    if (band >= 0) tau += sigma * (to - from);
    bool seen = sigma > kThinnest;
    if (seen || before) {
      uint mask_from = i > 0u && seen ? i - 1u : i, mask_to = seen ? min(i + 1u, cells.slices - 1u) : i;
      for (uint k = mask_from; k <= mask_to; ++k)
        for (int n = 0; n < 4; ++n) {
          ivec2 at = ivec2((n & 1) != 0 ? high.x : low.x, (n & 2) != 0 ? high.y : low.y);
          atomicOr(marks.at[(uint(at.y) * cells.nodes.x + uint(at.x)) * words + k / 32u], 1u << (k & 31u));
        }
    }
    before = seen;
  }
}
