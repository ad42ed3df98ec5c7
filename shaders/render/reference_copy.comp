#version 460
#extension GL_GOOGLE_include_directive : require
// Keeps what one frame shows behind its clouds for the path tracer's many dispatches.
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D depth_m;
layout(set = 0, binding = 1) uniform sampler2D albedo;
layout(set = 0, binding = 2) uniform sampler2D normal;
layout(set = 0, binding = 3) uniform sampler2D emission;
layout(set = 0, binding = 4) uniform sampler2D background;
layout(set = 0, binding = 5, r32f) uniform writeonly image2D out_depth_m;
layout(set = 0, binding = 6, rgba16f) uniform writeonly image2D out_albedo;
layout(set = 0, binding = 7, rgba16f) uniform writeonly image2D out_normal;
layout(set = 0, binding = 8, rgba16f) uniform writeonly image2D out_emission;
layout(set = 0, binding = 9, rgba32f) uniform writeonly image2D out_background;
void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(out_depth_m)))) return;
  imageStore(out_depth_m, at, texelFetch(depth_m, at, 0));
  imageStore(out_albedo, at, texelFetch(albedo, at, 0));
  imageStore(out_normal, at, texelFetch(normal, at, 0));
  imageStore(out_emission, at, texelFetch(emission, at, 0));
  imageStore(out_background, at, texelFetch(background, at, 0));
}
