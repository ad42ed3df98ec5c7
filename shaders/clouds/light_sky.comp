#version 460
#extension GL_GOOGLE_include_directive : require
// How the sky's luminance is spread over directions, against an even sky of the same illuminance: over the azimuth from the
// light (0 to pi) and the root of the zenith cosine, at one place and height.
#include "clouds/light_shared.h"
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(set = 0, binding = 1, r32f) uniform writeonly image2D out_sky;
#define ATMOSPHERE_BINDING 8
#include "atmosphere/atmosphere_lookup.glsl"
layout(push_constant, scalar) uniform PushBlock {
  vec3 up;          // geodetic normal of the place
  float height_m;
} push;

float luminance_of(vec3 rgb) { return dot(rgb, vec3(0.2126, 0.7152, 0.0722)); }

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID);
  if (any(greaterThanEqual(at, ivec2(kLightSkyTexels)))) return;
  FrameConstants f = frame.frame_data;
  float azimuth = (float(at.x) + 0.5) / float(kLightSkyTexels) * kPi;
  float root = (float(at.y) + 0.5) / float(kLightSkyTexels), mu = root * root;
  vec3 side = f.key_dir - push.up * dot(f.key_dir, push.up);
  side = dot(side, side) > 1.0e-8 ? normalize(side) : normalize(cross(push.up, abs(push.up.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
  vec3 dir = push.up * mu + (side * cos(azimuth) + cross(push.up, side) * sin(azimuth)) * sqrt(1.0 - mu * mu);
  float h = clamp(push.height_m, 0.0, atmosphere.air.top_m);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < count_lights(f, dir.x); ++i) {
    vec3 light = light_dir(f, i);
    float nu = clamp(dot(dir, light), -1.0, 1.0);
    float length_m = distance_to_top(atmosphere.air, h, mu);
    ScatteredLight s = scatter_along(h, mu, dot(push.up, light), nu, length_m, length_m, phase_rayleigh(nu), 1.0);
    sum += (s.smooth_part + s.mie * phase_aerosol(atmosphere.air, nu)) * light_factor(f, i);
  }
  float even = luminance_of(sky_illuminance(f, h, push.up) + f.night_illuminance) / kPi;
  imageStore(out_sky, at, vec4(luminance_of(sum + f.night_illuminance / kPi) / max(even, 1.0e-20)));
}
