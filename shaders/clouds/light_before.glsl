// Where the last frame's cells and nodes of light lie, for cells and nodes of this one.
//
// Needs FrameConstants `before.data`, LightBlock `light`.
#ifndef NEPHO_CLOUDS_LIGHT_BEFORE_GLSL
#define NEPHO_CLOUDS_LIGHT_BEFORE_GLSL
#include "clouds/light_cells.glsl"
#include "common/random.h"

// Place among the last frame's nodes (integers are nodes) of a direction or point as seen from its camera; false behind it.
bool light_before_node(vec3 q, LightCells cells, out vec2 node) {
  FrameConstants b = before.data;
  vec3 across = cross(b.right, b.up);
  float ahead = dot(q, across) / dot(b.forward, across);
  node = vec2(0.0);
  if (ahead <= 0.0) return false;
  vec3 over = cross(b.up, b.forward), beside = cross(b.forward, b.right);
  vec2 xy = vec2(dot(q, over) / dot(b.right, over), dot(q, beside) / dot(b.up, beside)) / ahead;
  node = (vec2(xy.x, -xy.y) * 0.5 + 0.5) * vec2(cells.nodes) - 0.5;
  return all(greaterThan(node, vec2(-1.0))) && all(lessThan(node, vec2(cells.nodes)));
}

// Fractions that rounding alone makes are none.
vec2 light_snap(vec2 f) { return mix(f, round(f), lessThan(abs(f - round(f)), vec2(2.0e-3))); }

// Whose turn it is in this frame.
bool light_turn(uint cell) { return (hash4(uvec4(cell, 0x51ed270bu, 0u, 0u)).x + light.data.frame_index) % light.data.cells.refresh_frames == 0u; }

// 1: it has no light yet, or little; 2: it has, and gets a path more now; 0: it waits.
uint light_wants(uint cell, float weight) { return weight < kLightEnough ? 1u : light_turn(cell) ? 2u : 0u; }

shared uint light_counts[2], light_firsts[2];

#endif
