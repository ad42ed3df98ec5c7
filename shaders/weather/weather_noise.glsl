// What the passes of the weather generator share.
#ifndef NEPHO_WEATHER_NOISE_GLSL
#define NEPHO_WEATHER_NOISE_GLSL
#include "common/noise.glsl"
#include "weather/weather_shared.h"

layout(scalar, set = 0, binding = 0) uniform GenerateBlock { WeatherGenerate generate_data; } generate;

const int kNoWrap = 1 << 20;

vec3 direction_of_texel(uvec3 id, float size) {
  return direction_from_cube(id.z, (vec2(id.xy) + 0.5) / size);
}

// Two unit tangents: east and north, any pair at the poles.
void tangents(vec3 dir, out vec3 east, out vec3 north) {
  vec3 e = vec3(-dir.y, dir.x, 0.0);
  float l = length(e);
  east = l > 1e-4 ? e / l : vec3(0.0, 1.0, 0.0);
  north = cross(dir, east);
}

// Sum of octaves from `frequency` (cycles per unit of p), each `gain` times the last; about unit variance. Octaves
// beyond `finest` cycles per unit, which the texels cannot hold, fade.
float fbm(vec3 p, float frequency, int octaves, float gain, float finest, uint seed) {
  float sum = 0.0, amplitude = 1.0, power = 0.0;
  for (int i = 0; i < octaves; ++i) {
    float keep = amplitude * (1.0 - smoothstep(0.6, 1.4, frequency / finest));
    sum += keep * gradient_noise(p * frequency + 31.7 * float(i), kNoWrap, seed + uint(i));
    power += amplitude * amplitude;
    amplitude *= gain;
    frequency *= 2.03;
    p = vec3(0.8 * p.x + 0.6 * p.y, 0.8 * p.y - 0.6 * p.x, p.z);  // octaves do not share their lattice
  }
  return sum / (0.28 * sqrt(power));
}

#endif
