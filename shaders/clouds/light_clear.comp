#version 460
// Zero to a 3D image of cells: vkCmdClearColorImage takes twenty times as long on some GPUs.
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba16f) uniform writeonly image3D out_cells;

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID);
  if (all(lessThan(at, imageSize(out_cells)))) imageStore(out_cells, at, vec4(0.0));
}
