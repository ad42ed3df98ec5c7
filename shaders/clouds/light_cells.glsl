// Where the cells of light_shared.h lie: along a ray from where it meets the shells around all layers.
#ifndef NEPHO_CLOUDS_LIGHT_CELLS_GLSL
#define NEPHO_CLOUDS_LIGHT_CELLS_GLSL
#include "clouds/light_shared.h"
#include "common/frame.h"

// Distance at which a ray from the camera enters the shells that hold all layers; below 0 where it does not.
float light_entry(PlanetView planet, CloudGrid grid, vec3 dir) {
  float low_m = grid.band_low_m[0], high_m = grid.band_high_m[grid.bands - 1u] * 1.0034 + 1.0;
  low_m -= max(-low_m, 0.0) * 0.0034 + 1.0;
  vec2 outer, inner;
  if (!intersect_shell(planet, dir, high_m, outer) || outer.y <= 0.0) return -1.0;
  if (intersect_shell(planet, dir, low_m, inner) && inner.y > 0.0 && inner.x <= 0.0) return inner.y;
  return max(outer.x, 0.0);
}

// Direction of the ray through a node.
vec3 light_node_direction(FrameConstants frame, LightCells cells, uvec2 node) {
  return pixel_direction(frame, (vec2(node) + 0.5) * vec2(frame.size) / vec2(cells.nodes) - frame.jitter_px);
}

#endif
