#version 460
#extension GL_GOOGLE_include_directive : require
// The wind that winds weather up: vortices, waves of the jets and turbulence, as the way (rad, along scaled axes) that
// air goes during the time of the trace. Free of divergence but for the texels.
#include "weather/weather_generate.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2DArray out_flow;

// Stream function of waves and turbulence.
float stream(vec3 p, uint seed) {
  float waves = gradient_noise(vec3(p.xy * 1.5, p.z * 2.2) + 7.3, kNoWrap, seed);
  float eddies = gradient_noise(p * 4.7 + 3.1, kNoWrap, seed + 1u);
  float small = gradient_noise(p * 13.0 + 5.7, kNoWrap, seed + 2u);
  return 0.20 * waves + 0.026 * eddies + 0.0040 * small;
}

void main() {
  uvec3 id = gl_GlobalInvocationID;
  uint size = uint(imageSize(out_flow).x);
  if (id.x >= size || id.y >= size) return;
  uint seed = generate.generate_data.seed;
  vec3 dir = direction_of_texel(id, float(size));
  vec3 east, north;
  tangents(dir, east, north);

  float e = 0.01;
  float along_east = (stream(dir + e * east, seed) - stream(dir - e * east, seed)) / (2.0 * e);
  float along_north = (stream(dir + e * north, seed) - stream(dir - e * north, seed)) / (2.0 * e);
  // The tropics have no jets to meander, and the poles no room for it.
  float calm = (0.22 + 0.78 * smoothstep(0.25, 0.60, abs(dir.z))) * (1.0 - 0.75 * smoothstep(0.80, 0.96, abs(dir.z)));
  vec3 flow = calm * (north * along_east - east * along_north);

  for (uint i = 0u; i < kWeatherVortices; ++i) {
    WeatherVortex v = generate.generate_data.vortices[i];
    vec3 d = dir - v.centre;
    float r2 = dot(d, d), q = r2 / (v.radius * v.radius);
    flow += cross(v.centre, dir) * (v.turn / (1.0 + q) * exp(-r2 * (v.tropical > 0.5 ? 30.0 : 5.0)));
  }
  // Trade winds blow from the east, westerlies from the west: what they shear.
  float lat = asin(clamp(dir.z, -1.0, 1.0)), trades = lat / 0.30, westerlies = (abs(lat) - 0.75) / 0.25;
  flow += east * (0.10 * cos(lat) * (0.8 * exp(-westerlies * westerlies) - exp(-trades * trades)));
  imageStore(out_flow, ivec3(id), vec4(flow, 0.0));
}
