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
layout(set = 0, binding = 21, r16f) uniform image3D out_grid;
layout(push_constant, scalar) uniform PushBlock { uint level; } push;

// A point given by its direction from the Earth's centre (scaled space) and its geodetic height, camera-relative: to half a metre.
vec3 point_at(PlanetView planet, vec3 dir, float height_m) {
  vec3 q = dir * (planet.a_m + scaled_height_from_geodetic(planet, dir, height_m));
  vec3 d = (q - planet.camera_q_m) - planet.camera_q_low_m;
  return vec3(d.xy, d.z / planet.a_over_b);
}

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID);
  CloudGrid grid = light.data.grid;
  int first = int(push.level * grid.slices);
  float half_m = region_half_m(grid.map, push.level);
  float texel_m = 2.0 * half_m / float(grid.texels);
  vec2 xy = (vec2(at) + 0.5) * texel_m - half_m;
  int quarter = int(grid.texels) / 4;
  bool inner = push.level > 0u && all(greaterThanEqual(at, ivec2(quarter))) && all(lessThan(at, ivec2(3 * quarter)));
  vec3 dir = region_direction(grid.map, xy);
  for (uint b = 0u; b < grid.bands; ++b) {
    int slices = int(grid.band_slices[b]), base = first + int(grid.band_first[b]);
    if (inner) {
      // The mean of the finer level.
      ivec2 child = (at - quarter) * 2;
      for (int i = 0; i < slices; ++i) {
        float sum = 0.0;
        for (int k = 0; k < 4; ++k) sum += imageLoad(out_grid, ivec3(child + ivec2(k & 1, k >> 1), base - int(grid.slices) + i)).r;
        imageStore(out_grid, ivec3(at, base + i), vec4(0.25 * sum));
      }
    } else {
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
            // The share of the slice that the slab fills.
            float thickness = CLOUD.layers[l].thickness_m, rise = 0.5 * step_m / thickness;
            sigma += (clamp(eta + rise, 0.0, 1.0) - clamp(eta - rise, 0.0, 1.0)) / (2.0 * rise) * CLOUD.uniform_density * CLOUD.layers[l].extinction_per_m;
          } else if (eta > 0.0 && eta < 1.0) {
            sigma += cloud_medium_at(l, columns[l], p, up, height_m, log2_footprint).sigma_per_m;
          }
        }
        imageStore(out_grid, ivec3(at, base + i), vec4(sigma));
      }
    }
  }
}
