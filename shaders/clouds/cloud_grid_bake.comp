#version 460
#extension GL_GOOGLE_include_directive : require
// Of all layers, r: mean extinction; g: extinction as scaled light on its way meets it; b: what the clump that scatters adds to
// the optical depth (as unscaled). At the centres of the grid's voxels, a column each invocation, with the footprint of a voxel.
#include "clouds/light_shared.h"
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_density.glsl"
#include "clouds/flight.glsl"
layout(scalar, set = 0, binding = 20) uniform LightBlock { CloudLightConstants data; } light;
layout(set = 0, binding = 21, rgba16f) uniform image3D out_grid;
layout(push_constant, scalar) uniform PushBlock { uint level, first_row; } push;

const float kAround_m = 15.0e3;

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID) + ivec2(0, int(push.first_row));
  CloudGrid grid = light.data.grid;
  int first = int(push.level * grid.slices);
  float half_m = region_half_m(grid.map, push.level);
  float texel_m = 2.0 * half_m / float(grid.texels);
  vec2 xy = (vec2(at) + 0.5) * texel_m - half_m * (1.0 - grid.shift);
  ivec2 quarter = ivec2(0.25 * float(grid.texels) * (1.0 - grid.shift) + 0.5);  // where the finer level begins
  bool inner = push.level > 0u && all(greaterThanEqual(at, quarter)) && all(lessThan(at, quarter + int(grid.texels) / 2));
  vec3 dir = region_direction(grid.map, xy);
  // Far outside of what the camera sees nothing matters: light comes from around what is seen.
  FrameConstants f = frame.frame_data;
  vec3 middle = point_at(f.planet, dir, 0.5 * (grid.band_low_m[0] + grid.band_high_m[grid.bands - 1u]));
  vec3 forward = normalize(f.forward);
  float along = dot(middle, forward), margin_m = max(kAround_m, 6.0 * texel_m);
  float aside = length(middle - along * forward), slope = length(vec2(length(f.right), length(f.up))) / length(f.forward);
  bool wanted = grid.all_around != 0u || (along > -margin_m && aside < slope * max(along, 0.0) + margin_m * (1.0 + slope));
  float rest = 1.0 - light.data.forward_albedo;
  // Slices that no band has are read by who looks for the largest around.
  int used = grid.bands > 0u ? int(grid.band_first[grid.bands - 1u] + grid.band_slices[grid.bands - 1u]) : 0;
  for (int i = used; i < int(grid.slices); ++i) imageStore(out_grid, ivec3(at, first + i), vec4(0.0));
  for (uint b = 0u; b < grid.bands; ++b) {
    int slices = int(grid.band_slices[b]), base = first + int(grid.band_first[b]);
    if (inner) {
      // The mean of the finer level.
      ivec2 child = (at - quarter) * 2;
      for (int i = 0; i < slices; ++i) {
        vec3 sum = vec3(0.0);
        for (int k = 0; k < 4; ++k) sum += imageLoad(out_grid, ivec3(child + ivec2(k & 1, k >> 1), base - int(grid.slices) + i)).rgb;
        imageStore(out_grid, ivec3(at, base + i), vec4(0.25 * sum, 0.0));
      }
    } else if (!wanted) {
      for (int i = 0; i < slices; ++i) imageStore(out_grid, ivec3(at, base + i), vec4(0.0));
    } else {
      float low_m = grid.band_low_m[b], step_m = (grid.band_high_m[b] - low_m) / float(slices);
      float log2_footprint = log2(texel_m);
      vec3 foot = point_at(CLOUD_PLANET, dir, low_m);
      vec3 up = geodetic_up(CLOUD_PLANET, foot);
      CloudWeather weather = cloud_weather_at(foot, up, log2_footprint);
      CloudColumn columns[LAYERS];
      for (uint l = 0u; l < LAYERS; ++l) columns[l] = cloud_column(l, weather, foot, up, low_m, log2_footprint);
      for (int i = 0; i < slices; ++i) {
        float height_m = low_m + (float(i) + 0.5) * step_m, sigma = 0.0, hiding = 0.0, own = 0.0;
        vec3 p = point_at(CLOUD_PLANET, dir, height_m);
        for (uint l = 0u; l < LAYERS; ++l) {
          float eta = cloud_eta(l, columns[l], height_m);
          if (CLOUD.uniform_density > 0.0) {
            // The share of the slice that the slab fills.
            float thickness = CLOUD.layers[l].thickness_m, rise = 0.5 * step_m / thickness;
            float slab = (clamp(eta + rise, 0.0, 1.0) - clamp(eta - rise, 0.0, 1.0)) / (2.0 * rise) * CLOUD.uniform_density * CLOUD.layers[l].extinction_per_m;
            sigma += slab;
            hiding += slab;
          } else if (eta > 0.0 && eta < 1.0) {
            // Light finds ways between clumps that the footprint hides, but what it does not miss scatters all of it.
            CloudMedium m = cloud_medium_at(l, columns[l], p, up, height_m, log2_footprint);
            sigma += m.mean_per_m;
            if (m.clump_depth > 0.0) {
              float size_m = clamp(0.5 * texel_m, 1.0, 0.5 * CLOUD.layers[l].thickness_m), inside = m.clump_depth / size_m;
              float x = inside * rest * size_m, hides = clumped_extinction(m.mean_per_m / inside, inside * rest, size_m);
              hiding += hides / rest;
              // What scatters is in a clump, and its own shade falls on it: mean transmittance over the depth of a clump, instead of that
              // through as much of the mixture.
              float depth = x > 1.0e-3 ? -log((1.0 - exp(-x)) / x) : 0.5 * x;
              own += m.mean_per_m * max(depth - 0.5 * hides * size_m, 0.0) / rest;
            }
          }
        }
        imageStore(out_grid, ivec3(at, base + i), vec4(sigma, hiding, sigma > 0.0 ? own / sigma : 0.0, 0.0));
      }
    }
  }
}
