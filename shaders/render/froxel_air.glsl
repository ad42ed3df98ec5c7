// Air from the camera to any point of the picture's frustum, by the grid that froxel_fill makes: shaded by clouds, with haze. For the march of
// clouds, which needs it at many points of a ray.
//
//   #define FROXEL_BINDING 40        // takes this binding and the two after it; bind_froxels() fills them
#ifndef NEPHO_FROXEL_AIR_GLSL
#define NEPHO_FROXEL_AIR_GLSL
#include "render/shaft_shared.h"
layout(scalar, set = 0, binding = FROXEL_BINDING) uniform FroxelBlock { FroxelGrid grid; } froxels;
layout(set = 0, binding = FROXEL_BINDING + 1) uniform sampler3D froxel_light;
layout(set = 0, binding = FROXEL_BINDING + 2) uniform sampler3D froxel_transmittance;

// uv: place in the picture, 0..1, y down. Luminance of the air before the point at distance_m and, out, the transmittance of air and haze to it.
vec3 froxel_air(vec2 uv, float distance_m, out vec3 transmittance) {
  float x = froxel_slice(froxels.grid, distance_m), first = min(x, 1.0);
  vec3 at = vec3(uv, (x - 0.5) / float(froxels.grid.size.z));
  // In the first slice it grows from nothing.
  transmittance = mix(vec3(1.0), textureLod(froxel_transmittance, at, 0.0).rgb, first);
  return textureLod(froxel_light, at, 0.0).rgb * first;
}
#endif
