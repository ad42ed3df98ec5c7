#version 460
#extension GL_GOOGLE_include_directive : require
// Where the air of each place has come from: back along the flow, for all of the time and for a third of it.
#include "weather/weather_generate.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 1) uniform samplerCube flow_tex;
layout(set = 0, binding = 2, rgba32f) uniform writeonly image2DArray out_origin;
layout(set = 0, binding = 3, rgba32f) uniform writeonly image2DArray out_recent;

const int kSteps = 18;

void main() {
  uvec3 id = gl_GlobalInvocationID;
  uint size = uint(imageSize(out_origin).x);
  if (id.x >= size || id.y >= size) return;
  vec3 p = direction_of_texel(id, float(size));
  float step = 1.0 / float(kSteps);
  for (int i = 0; i < kSteps; ++i) {
    vec3 half_way = normalize(p - 0.5 * step * textureLod(flow_tex, p, 0.0).xyz);
    p = normalize(p - step * textureLod(flow_tex, half_way, 0.0).xyz);
    if (i == kSteps / 3 - 1) imageStore(out_recent, ivec3(id), vec4(p, 0.0));
  }
  imageStore(out_origin, ivec3(id), vec4(p, 0.0));
}
