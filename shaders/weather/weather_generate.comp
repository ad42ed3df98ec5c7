#version 460
#extension GL_GOOGLE_include_directive : require
// Large-scale weather as one number per direction, higher is cloudier; the CPU equalises it (weather_map.cpp).
// Noise is three-dimensional and read on the sphere, so cube edges, poles and the antimeridian cannot show.
#include "common/noise.glsl"
#include "weather/weather_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform GenerateBlock { WeatherGenerate generate_data; } generate;
layout(set = 0, binding = 1, r32f) uniform writeonly image2DArray out_weather;

const int kNoWrap = 1 << 20;

vec3 turned(vec3 p, vec3 axis, float angle) {
  float c = cos(angle), s = sin(angle);
  return p * c + cross(axis, p) * s + axis * (dot(axis, p) * (1.0 - c));
}

// Sum of octaves from `frequency` (cycles per unit of p), each a little weaker; unit variance, about.
float fbm(vec3 p, float frequency, int octaves, float gain, uint seed) {
  float sum = 0.0, amplitude = 1.0, power = 0.0;
  for (int i = 0; i < octaves; ++i) {
    sum += amplitude * gradient_noise(p * frequency + 31.7 * float(i), kNoWrap, seed + uint(i));
    power += amplitude * amplitude;
    amplitude *= gain;
    frequency *= 2.03;
    p = vec3(0.8 * p.x + 0.6 * p.y, 0.8 * p.y - 0.6 * p.x, p.z);  // octaves do not share their lattice
  }
  return sum / (0.28 * sqrt(power));
}

void main() {
  uvec3 id = gl_GlobalInvocationID;
  uint size = generate.generate_data.size;
  if (id.x >= size || id.y >= size) return;
  uint seed = generate.generate_data.seed;
  vec2 uv = (vec2(id.xy) + 0.5) / float(size) * 2.0 - 1.0;
  vec3 dir = cube_direction(id.z, uv.x, uv.y);

  // Cyclones turn the domain about their centres, more in the middle: fronts wind up into spirals and commas.
  vec3 p = dir;
  float eye = 0.0;
  for (uint i = 0u; i < kWeatherVortices; ++i) {
    vec4 v = generate.generate_data.vortices[i];
    float radius = generate.generate_data.vortex_size.x + generate.generate_data.vortex_size.y * float(i);
    vec3 d = p - v.xyz;
    float q = dot(d, d) / (radius * radius);
    if (q > 9.0) continue;
    float fall = exp(-q);
    p = turned(p, v.xyz, v.w * fall);
    eye = max(eye, fall);
  }
  // Shear along parallels, then two rounds of warping: filaments instead of blobs.
  vec3 warp = vec3(fbm(p, 1.7, 3, 0.5, seed + 11u), fbm(p, 1.7, 3, 0.5, seed + 23u), fbm(p, 1.7, 3, 0.5, seed + 37u));
  vec3 q = p + 0.10 * warp;
  vec3 warp2 = vec3(fbm(q, 5.0, 2, 0.5, seed + 41u), fbm(q, 5.0, 2, 0.5, seed + 53u), fbm(q, 5.0, 2, 0.5, seed + 67u));
  q += 0.035 * warp2;

  float zonal = fbm(q * vec3(1.0, 1.0, 2.2), 2.1, 8, 0.62, seed + 71u);
  float ridge = 1.0 - 1.6 * abs(fbm(q * vec3(1.0, 1.0, 1.6), 2.6, 5, 0.55, seed + 97u));  // fronts

  // Climate by latitude (of dir, wandering with the low warp): wet equator, dry 15..32 deg, stormy 40..65 deg.
  float lat = degrees(asin(clamp(dir.z + 0.06 * warp.x, -1.0, 1.0)));
  float a = abs(lat);
  float itcz = exp(-pow((lat - 5.0) / 7.5, 2.0));
  float dry = exp(-pow((a - 23.0) / 10.0, 2.0));
  float storm = exp(-pow((a - 54.0) / 15.0, 2.0));
  float climate = 0.75 * itcz - 0.85 * dry + 0.65 * storm - 0.35 * smoothstep(70.0, 88.0, a);
  float value = 0.75 * zonal + 0.35 * ridge * (0.4 + storm) + climate + 0.35 * eye * storm;
  imageStore(out_weather, ivec3(id), vec4(value));
}
