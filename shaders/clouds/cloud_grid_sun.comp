#version 460
#extension GL_GOOGLE_include_directive : require
// Optical depth from the grid's voxels to the key light, through the grid itself (cloud_grid_bake.comp): mean, and as scaled light meets it: steps of about a voxel that grow with distance.
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_PLANET frame.frame_data.planet
layout(set = 0, binding = 1) uniform sampler3D grid_tex;
layout(set = 0, binding = 4) uniform sampler3D most_tex;
#include "clouds/cloud_grid.glsl"
layout(scalar, set = 0, binding = 2) uniform LightBlock { CloudLightConstants data; } light;
layout(set = 0, binding = 3, rgba16f) uniform writeonly image3D out_grid;

layout(push_constant, scalar) uniform PushBlock { uint first_plane; } push;

const int kSteps = 72;
const float kFirstStep = 0.35;  // voxels
const float kGrowth = 0.07;
const float kDeepest = 80.0;    // optical depth beyond which no light is left: the share that counts is above a third of it

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID) + ivec3(0, 0, int(push.first_plane));
  CloudGrid grid = light.data.grid;
  int level = at.z / int(grid.slices);
  int slice = at.z - level * int(grid.slices);
  int band = -1;
  for (uint b = 0u; b < grid.bands; ++b)
    if (float(slice) >= grid.band_first[b] && float(slice) < grid.band_first[b] + grid.band_slices[b]) band = int(b);
  if (band < 0) {  // a filter may read it with a weight of 0
    imageStore(out_grid, at, vec4(0.0));
    return;
  }
  float half_m = region_half_m(grid.map, uint(level));
  float texel_m = 2.0 * half_m / float(grid.texels);
  vec2 xy = (vec2(at.xy) + 0.5) * texel_m - half_m * (1.0 - grid.shift);
  // Nobody asks where a finer level is read, nor where nothing is around.
  bool wanted = level == 0 || any(greaterThan(abs(xy - 0.5 * half_m * grid.shift), vec2(0.5 * half_m * (1.0 - 12.0 / float(grid.texels)))));
  if (wanted) wanted = texelFetch(most_tex, at / 2, 0).r > 0.0;
  vec3 sun = frame.frame_data.key_dir;
  float low_m = grid.band_low_m[band], slice_m = (grid.band_high_m[band] - low_m) / grid.band_slices[band];
  vec3 dir = region_direction(grid.map, xy);
  vec3 p = point_at(CLOUD_PLANET, dir, low_m + (float(slice) - grid.band_first[band] + 0.5) * slice_m);
  Flight f = flight_from(p, sun);
  float climb0 = abs(dot(place_on(f).up, sun));
  // A part of a voxel's length along the ray.
  float step_m = kFirstStep * min(texel_m / max(sqrt(1.0 - climb0 * climb0), 0.05), slice_m / max(climb0, 0.02));
  vec3 here_medium = texelFetch(grid_tex, at, 0).rgb;
  vec2 tau = vec2(0.0), sigma0 = here_medium.rg;
  for (int i = 0; i < kSteps && wanted; ++i) {
    f.s += step_m;
    Place here = place_on(f);
    float above_m, below_m;
    int b = grid_band(grid, here.height_m, above_m, below_m);
    vec2 sigma = vec2(0.0);
    if (b >= 0) {
      sigma = grid_read(grid, b, here).xy;
      tau += 0.5 * (sigma0 + sigma) * step_m;
    } else {
      tau += 0.5 * sigma0 * step_m;
      float climb = dot(here.up, sun);
      float leap = min(above_m < kFar_m ? length_rising(above_m + 0.5, climb) : kFar_m, below_m < kFar_m ? length_sinking(below_m + 0.5, climb) : kFar_m);
      if (leap >= kFar_m) break;
      f.s += leap;
    }
    if (tau.y > kDeepest) break;
    sigma0 = sigma;
    step_m *= 1.0 + kGrowth;
  }
  imageStore(out_grid, at, vec4(here_medium.r, tau, tau.y + here_medium.b));
}
