// Pixels that a pass draws where it does not draw all: a compact list, neighbours together, dispatched indirectly.
//
//   #define PIXEL_LIST_BINDING 40
//   #define PIXEL_LIST_CONSTANT 10
//   #include "clouds/pixel_list.glsl"
layout(constant_id = PIXEL_LIST_CONSTANT) const bool LISTED = false;
layout(scalar, set = 0, binding = PIXEL_LIST_BINDING) readonly buffer PixelListBlock { uint at[]; } pixel_list;  // x | y << 16
layout(scalar, set = 0, binding = PIXEL_LIST_BINDING + 1) readonly buffer PixelCountBlock { uvec4 groups; } pixel_count;  // w: pixels

bool listed_pixel(uint index, out ivec2 pixel) {
  bool there = index < pixel_count.groups.w;
  uint at = there ? pixel_list.at[index] : 0u;
  pixel = ivec2(at & 0xffffu, at >> 16);
  return there;
}
