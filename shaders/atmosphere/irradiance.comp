#version 460
#extension GL_GOOGLE_include_directive : require
// Sums one order's incident light: irradiance of a horizontal plane from above the horizontal, and mean radiance of the
// hemispheres above and below it. Three tables stacked in y.
#include "atmosphere/atmosphere_shared.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform AtmosphereBlock { AtmosphereUniform atmosphere_data; } atmosphere;
layout(scalar, set = 0, binding = 1) readonly buffer IncidentBlock { vec4 data[]; } incident;
layout(set = 0, binding = 2, rgba32f) uniform writeonly image2D out_order;  // this order alone
layout(set = 0, binding = 3, rgba32f) uniform image2D sum;                  // of all orders
layout(push_constant) uniform Push { int order; } push;

void main() {
  ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
  if (texel.x >= kAirMuS || texel.y >= kAirR) return;
  AtmosphereUniform air = atmosphere.atmosphere_data;
  float h = height_from_unit(air, unit_from_texel(texel.y, kAirR));
  int base = (texel.y * kAirMuS + texel.x) * kIncidentDirections;
  vec3 part[3] = {vec3(0), vec3(0), vec3(0)};
  for (int i = 0; i < kIncidentMu; ++i) {
    vec2 mu = incident_mu(air, h, i);
    vec3 light = vec3(0);
    for (int j = 0; j < kIncidentPhi; ++j) light += incident.data[base + i * kIncidentPhi + j].rgb;
    light *= mu.y * (2.0 * kPi / float(kIncidentPhi));  // both halves of the azimuth
    if (i >= kIncidentGround + kIncidentBand) {
      part[0] += light * mu.x;
      part[1] += light * (0.5 / kPi);
    } else {
      part[2] += light * (0.5 / kPi);
    }
  }
  for (int k = 0; k < 3; ++k) {
    ivec2 at = texel + ivec2(0, k * kAirR);
    imageStore(out_order, at, vec4(part[k], 0));
    imageStore(sum, at, vec4(part[k], 0) + (push.order > 1 ? imageLoad(sum, at) : vec4(0)));
  }
}
