#version 460
#extension GL_GOOGLE_include_directive : require
// Where no shadow of terrain is near: 1 where around a texel of the map of shadow heights shadows end so far below the ground
// that no point between these texels has any, by half of what light climbs across a texel; else 0. Most ground is so.
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#include "terrain/terrain_shadow_shared.h"
layout(set = 0, binding = 1) uniform sampler2DArray terrain_shadow_tex;
layout(scalar, set = 0, binding = 2) uniform TerrainShadowBlock { TerrainShadowConstants data; } terrain_shadow;
layout(set = 0, binding = 3) uniform sampler2DArray volume_tex;
layout(set = 0, binding = 4, r32f) uniform writeonly image2DArray out_lit;
layout(push_constant) uniform Push { uint first_level; } push;

void main() {
  ivec3 texel = ivec3(gl_GlobalInvocationID) + ivec3(0, 0, push.first_level);
  PlanetView planet = frame.frame_data.planet;
  RegionMap map = terrain_shadow.data.map;
  float half_m = region_half_m(map, uint(texel.z)), texel_m = 2.0 * half_m / float(kShadowTexels);
  vec3 dir = region_direction(map, ((vec2(texel.xy) + 0.5) / float(kShadowTexels) - 0.5) * 2.0 * half_m);
  float rising = dot(normalize(vec3(dir.xy, dir.z * planet.a_over_b)), frame.frame_data.key_dir);
  float tangent = rising / sqrt(max(1.0 - rising * rising, 1.0e-4));
  float margin_m = min(0.5 * texel_m * tangent, 0.8 * deepest_shade_m(texel_m));
  // Lower light grazes: it may be half hidden by even ground.
  bool lit = rising > 0.05;
  for (int i = 0; i < 9 && lit; ++i) {
    ivec3 at = ivec3(clamp(texel.xy + ivec2(i % 3, i / 3) - 1, ivec2(0), ivec2(kShadowTexels - 1u)), texel.z);
    vec4 edge = texelFetch(volume_tex, at, 0);
    lit = max(edge.x, edge.z + edge.w) < texelFetch(terrain_shadow_tex, at, 0).r - margin_m;
  }
  imageStore(out_lit, texel, vec4(lit ? 1.0 : 0.0));
}
