#version 460
// Writes which tile is seen and where on it; attributes follow in terrain_resolve.comp.
layout(location = 0) in vec2 in_uv;
layout(location = 1) flat in uint in_tile;
layout(location = 0) out uvec2 out_id;  // place on the tile as two 16-bit fractions; tile of the draw list + 1, 0: sky

void main() { out_id = uvec2(packUnorm2x16(clamp(in_uv, 0.0, 1.0)), in_tile + 1u); }
