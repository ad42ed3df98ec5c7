#version 460
#extension GL_GOOGLE_include_directive : require
// A volume of noise that repeats after 16 cells, four texels a cell, for the generator's octaves: reading four noises at
// once is ten times as quick as hashing them. rgb: gradient noise of unit variance, a: cells, 1 at their centres.
#include "weather/weather_generate.glsl"
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(set = 0, binding = 1, rgba16f) uniform writeonly image3D out_noise;

void main() {
  ivec3 id = ivec3(gl_GlobalInvocationID);
  vec3 p = (vec3(id) + 0.5) / 4.0;
  uint seed = generate.generate_data.seed + 100u;
  vec4 v;
  for (int i = 0; i < 3; ++i) v[i] = gradient_noise(p, 16, seed + uint(i)) / 0.28;
  v.a = 1.0 - worley_distance(p, 16, seed + 3u);
  imageStore(out_noise, id, v);
}
