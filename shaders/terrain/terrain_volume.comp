#version 460
#extension GL_GOOGLE_include_directive : require
// How high terrain's shadows reach: over every place of the map up to which height the key light's disc is hidden. Terrain is a
// field of heights and light comes from above, so that over a place all that is shaded lies below one height.
//
// Of all ground g(t) along the way to the light, whose line rises by f(t), each hides half of the disc (of radius r) at the height
// g - f and has a penumbra of t r metres on either side. Two are kept: the one that hides half of the disc highest up, and the
// one whose penumbra ends highest up.
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#include "terrain/terrain_shadow_shared.h"
layout(set = 0, binding = 1) uniform sampler2DArray terrain_shadow_tex;
layout(scalar, set = 0, binding = 2) uniform TerrainShadowBlock { TerrainShadowConstants data; } terrain_shadow;
layout(set = 0, binding = 3, rgba32f) uniform writeonly image2DArray out_volume;  // xy: height and half width of the first, m; zw: of the second

layout(push_constant) uniform Push { uint first_level; } push;

const int kSteps = 640;
const float kTolerance = 0.1;   // of the half width of a penumbra: what raises a shadow by less may be leapt over

void main() {
  ivec3 texel = ivec3(gl_GlobalInvocationID) + ivec3(0, 0, push.first_level);
  PlanetView planet = frame.frame_data.planet;
  RegionMap map = terrain_shadow.data.map;
  float highest = terrain_shadow.data.highest_m, radius = frame.frame_data.sun_angular_radius_rad;
  vec3 scaled_light = scaled_from_cam(planet, frame.frame_data.key_dir);
  float own_half_m = map.half_m * exp2(float(texel.z)), own_texel_m = 2.0 * own_half_m / float(kShadowTexels);
  vec2 place = ((vec2(texel.xy) + 0.5) / float(kShadowTexels) - 0.5) * 2.0 * own_half_m;
  vec3 start_dir = region_direction(map, place);
  float start_m = texelFetch(terrain_shadow_tex, texel, 0).r;
  float scaled_m = scaled_height_from_geodetic(planet, start_dir, start_m);
  vec3 q0 = start_dir * (planet.a_m + scaled_m);
  float f0 = scaled_m * (2.0 * planet.a_m + scaled_m), slope = 2.0 * dot(q0, scaled_light), bend = dot(scaled_light, scaled_light);
  float root0 = planet.a_m + scaled_m;
  // Heights over the start, until the end: half hidden, end of the penumbra; and their half widths.
  float half_m = -deepest_shade_m(own_texel_m), end_m = half_m;
  float half_width_m = 1.0, end_width_m = 1.0;
  float t = 0.0;
  int mip = 0;
  // The inner part of a level is the finer one's.
  bool wanted = texel.z == 0 || max(abs(place.x), abs(place.y)) > 0.5 * own_half_m - 3.0 * own_texel_m;
  for (int i = 0; i < kSteps && wanted; ++i) {
    vec3 q = q0 + scaled_light * t;
    vec3 sq = vec3(q.xy, q.z * planet.a_over_b);
    float inv = inversesqrt(dot(sq, sq)), gained = t * (slope + t * bend);
    float rise_m = gained / (root0 + sqrt(planet.a_m * planet.a_m + f0 + gained)) * (length(q) * inv);
    float rising = dot(sq * inv, frame.frame_data.key_dir);
    vec3 dir = normalize(q);
    vec2 xy = region_xy(map, dir);
    float away = max(abs(xy.x), abs(xy.y));
    float level = max(floor(log2(max(away * (float(kShadowTexels) / float(kShadowTexels - 1u)) / map.half_m, 0.5))) + 1.0, 0.0);
    if (level >= float(map.levels)) break;
    float level_half_m = map.half_m * exp2(level), texel_m = 2.0 * level_half_m / float(kShadowTexels);
    vec2 uv = xy * (0.5 / level_half_m) + 0.5;
    float per_m = 1.0 / max(sqrt(max(1.0 - rising * rising, 0.0)) * region_stretch(map, dir) * 1.004, 0.02);
    if (i > 0) {
      float most_m = highest - start_m - rise_m;  // nothing ahead is higher over the line
      if (rising > radius && most_m < half_m && most_m + radius * t < end_m) break;
      if (mip == 0) {
        float over_m = textureLod(terrain_shadow_tex, vec3(uv, level), 0.0).r - start_m - rise_m, width_m = t * radius;
        mip = over_m < half_m + kTolerance * width_m && over_m + width_m < end_m + kTolerance * width_m ? 1 : 0;
        if (over_m > half_m) {
          half_m = over_m;
          half_width_m = width_m;
        }
        if (over_m + width_m > end_m) {
          end_m = over_m + width_m;
          end_width_m = width_m;
        }
      } else {
        ivec2 cell = clamp(ivec2(uv * float(kShadowTexels)), ivec2(0), ivec2(kShadowTexels - 1u)) >> mip;
        float top = texelFetch(terrain_shadow_tex, ivec3(cell, int(level)), mip).r;
        float ahead = texel_m * exp2(float(mip)) * per_m;
        float over_m = top - start_m - min(rise_m, rise_m + rising * ahead);
        float tolerance_m = kTolerance * radius * t;
        if (over_m <= half_m + tolerance_m && over_m + radius * (t + ahead) <= end_m + tolerance_m) {
          t += min(ahead, (level_half_m - away + texel_m) * per_m);
          mip = min(mip + 1, int(kShadowMips) - 1);
          continue;
        }
        --mip;
        continue;
      }
    }
    t += max((i > 0 ? 0.5 : 1.0) * texel_m * per_m, 0.002 * t);
  }
  imageStore(out_volume, texel, vec4(start_m + half_m, half_width_m, start_m + end_m - end_width_m, end_width_m));
}
