#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/shared.h"
// Writes base + x + 100 y into an image, plus last frame's value.
layout(local_size_x = 8, local_size_y = 4) in;
struct Settings { float base; };
layout(set = 0, binding = 0, scalar) uniform SettingsBlock { Settings values; } settings;
layout(set = 0, binding = 1, r32f) uniform writeonly image2D result;
layout(set = 0, binding = 2) uniform sampler2D last;
layout(push_constant, scalar) uniform Push { vec3 unused; float scale; } push;
void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(p, imageSize(result)))) return;
  float old = texelFetch(last, p, 0).r;
  imageStore(result, p, vec4(old + push.scale * (settings.values.base + float(p.x) + 100.0 * float(p.y))));
}
