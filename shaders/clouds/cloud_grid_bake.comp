#version 460
#extension GL_GOOGLE_include_directive : require
// Extinction of all layers at the centres of the grid's voxels, a column each invocation, with the footprint of a voxel.
#include "clouds/light_shared.h"
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_density.glsl"
#include "clouds/flight.glsl"
layout(scalar, set = 0, binding = 20) uniform LightBlock { CloudLightConstants data; } light;
layout(set = 0, binding = 21, rg16f) uniform writeonly image3D out_grid;
layout(scalar, set = 0, binding = 22) buffer FactsBlock { GridFacts data; } facts;

// A point given by its direction from the Earth's centre (scaled space) and its geodetic height, camera-relative: to half a metre.
vec3 point_at(PlanetView planet, vec3 dir, float height_m) {
  vec3 q = dir * (planet.a_m + scaled_height_from_geodetic(planet, dir, height_m));
  vec3 d = (q - planet.camera_q_m) - planet.camera_q_low_m;
  return vec3(d.xy, d.z / planet.a_over_b);
}

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID);
  CloudBounds grid = light.data.grid;
  int first = at.z * int(kBoundsSlices);
  float half_m = region_half_m(grid.map, uint(at.z));
  float texel_m = 2.0 * half_m / float(kBoundsTexels);
  vec2 xy = (vec2(at.xy) + 0.5) * texel_m - half_m;
  // Where a finer level is read instead nothing is asked.
  bool hidden = at.z > 0 && max(abs(xy.x), abs(xy.y)) < 0.5 * half_m * (1.0 - 3.0 / float(kBoundsTexels));
  vec3 dir = region_direction(grid.map, xy);
  float most = 0.0;
  for (uint b = 0u; b < grid.bands && !hidden; ++b) {
    int slices = int(grid.band_slices[b]), base = first + int(grid.band_first[b]);
    float low_m = grid.band_low_m[b], step_m = (grid.band_high_m[b] - low_m) / float(slices);
    float log2_footprint = log2(texel_m);
    vec3 foot = point_at(CLOUD_PLANET, dir, low_m);
    vec3 up = geodetic_up(CLOUD_PLANET, foot);
    CloudWeather weather = cloud_weather_at(foot, up, log2_footprint);
    CloudColumn columns[LAYERS];
    for (uint l = 0u; l < LAYERS; ++l) columns[l] = cloud_column(l, weather, foot, up, low_m, log2_footprint);
    for (int i = 0; i < slices; ++i) {
      float height_m = low_m + (float(i) + 0.5) * step_m, sigma = 0.0;
      vec3 p = point_at(CLOUD_PLANET, dir, height_m);
      for (uint l = 0u; l < LAYERS; ++l) {
        float eta = cloud_eta(l, columns[l], height_m);
        if (CLOUD.uniform_density > 0.0) {
          sigma += eta >= 0.0 && eta < 1.0 ? CLOUD.uniform_density * CLOUD.layers[l].extinction_per_m : 0.0;
        } else if (eta > 0.0 && eta < 1.0) {
          sigma += cloud_medium_at(l, columns[l], p, up, height_m, log2_footprint).sigma_per_m;
        }
      }
      most = max(most, sigma);
      imageStore(out_grid, ivec3(at.xy, base + i), vec4(sigma, 0.0, 0.0, 0.0));
    }
  }
  if (most > 0.0) atomicMax(facts.data.most, floatBitsToUint(most * 1.001));  // half floats round
}
