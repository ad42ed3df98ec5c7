// Nodes of light on the ground: where they lie, and how far light on it is alike.
#ifndef NEPHO_CLOUDS_LIGHT_NODES_GLSL
#define NEPHO_CLOUDS_LIGHT_NODES_GLSL
#include "clouds/light_shared.h"
#include "common/frame.h"

ivec2 light_ground_pixel(FrameConstants f, LightCells cells, uvec2 node) {
  return min(ivec2((vec2(node) + 0.5) * vec2(f.size) / vec2(cells.nodes)), ivec2(f.size) - 1);
}

vec3 light_ground_direction(FrameConstants f, LightCells cells, uvec2 node) {
  return pixel_direction(f, vec2(light_ground_pixel(f, cells, node)) + 0.5);
}

// Seen from far below, clouds light neighbouring places alike: within a share of their height over the place p.
float light_ground_radius_m(PlanetView planet, CloudGrid grid, vec3 p) {
  const float kShare = 0.2;
  const float kLeast_m = 50.0;  // where clouds lie on the ground
  return max(kShare * (grid.band_low_m[0] - geodetic_height(planet, p)), kLeast_m);
}

#endif
