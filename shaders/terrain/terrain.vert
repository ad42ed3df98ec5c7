#version 460
#extension GL_GOOGLE_include_directive : require
// Places a tile's vertices. Their ECEF positions come in two floats and become camera-relative here, so that a vertex
// which two tiles share has the same bits in both, and the surface is watertight without skirts.
#include "common/frame.h"
#include "terrain/terrain_shared.h"

layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(scalar, set = 0, binding = 1) readonly buffer VertexBlock { uvec4 at[]; } vertices;  // TileVertex, two each
layout(scalar, set = 0, binding = 2) readonly buffer TileBlock { TerrainTile at[]; } tiles;
layout(scalar, push_constant) uniform Push { TerrainRasterPush push; };

layout(location = 0) out vec2 out_uv;
layout(location = 1) flat out uint out_tile;
invariant gl_Position;

void main() {
  TerrainTile tile = tiles.at[gl_InstanceIndex];
  uint index = uint(gl_VertexIndex);
  uint base = (tile.slot * kTerrainVertices + terrain_vertex(index, tile.edges)) * 2u;
  uvec4 a = vertices.at[base];
  uvec4 b = vertices.at[base + 1u];
  vec3 hi = uintBitsToFloat(a.xyz);
  vec3 lo = uintBitsToFloat(uvec3(a.w, b.xy));
  vec3 to_parent = vec3(unpackHalf2x16(b.z), unpackHalf2x16(b.w).x);
  float left = 1.0 - terrain_morph(index, tile.morph, tile.edge_morph, tile.corner_morph);
  precise vec3 p = ((hi - push.camera_hi_m) + (lo - push.camera_lo_m)) + left * to_parent;
  // p = w (forward + x right + y up); reversed Z with the far plane at infinity: depth = near / w.
  FrameConstants f = frame.frame_data;
  precise float w = dot(p, f.forward);
  precise float x = dot(p, f.right) / dot(f.right, f.right);
  precise float y = dot(p, f.up) / dot(f.up, f.up);
  vec2 jitter = 2.0 * f.jitter_px / vec2(f.size);
  gl_Position = vec4(x - w * jitter.x, -y - w * jitter.y, f.near_m, w);
  out_uv = vec2(float(index % 65u), float(index / 65u)) / 64.0;
  out_tile = uint(gl_InstanceIndex);
}
