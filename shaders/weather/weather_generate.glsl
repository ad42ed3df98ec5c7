// What the passes of the weather generator share.
#ifndef NEPHO_WEATHER_GENERATE_GLSL
#define NEPHO_WEATHER_GENERATE_GLSL
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

#endif
