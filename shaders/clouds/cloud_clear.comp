#version 460
// The outputs of cloud_march.comp for a clear sky.
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba32f) uniform writeonly image2D out_radiance;
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2D out_info;
layout(set = 0, binding = 2, rgba32f) uniform writeonly image2D out_near;
layout(set = 0, binding = 3, rg32f) uniform writeonly image2D out_depths;

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, imageSize(out_radiance)))) return;
  imageStore(out_radiance, pixel, vec4(0.0, 0.0, 0.0, 1.0));
  imageStore(out_info, pixel, vec4(1.0e10, 0.0, 0.0, 0.0));
  imageStore(out_near, pixel, vec4(0.0));
  imageStore(out_depths, pixel, vec4(1.0e10));
}
