#version 460
#extension GL_GOOGLE_include_directive : require
// Turns the G-buffer into what shading needs: distance along the ray, albedo with mask, normal, night lights.
#include "common/frame.h"
#include "terrain/terrain_shared.h"

layout(local_size_x = 16, local_size_y = 16) in;  // a tile
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(scalar, set = 0, binding = 1) readonly buffer TileBlock { TerrainTile at[]; } tiles;
layout(set = 0, binding = 2) uniform sampler2D depth_tex;
layout(set = 0, binding = 3) uniform usampler2D id_tex;
layout(set = 0, binding = 4) uniform sampler2DArray imagery_tex;
layout(set = 0, binding = 5) uniform sampler2DArray slope_tex;
layout(set = 0, binding = 6) uniform sampler2D night_tex;
layout(set = 0, binding = 7, r32f) uniform writeonly image2D out_depth_m;
layout(set = 0, binding = 8, rgba16f) uniform writeonly image2D out_albedo;
layout(set = 0, binding = 9, rgba16f) uniform writeonly image2D out_normal;
layout(set = 0, binding = 10, rgba16f) uniform writeonly image2D out_emission;
#define PIXEL_TILES_BINDING 11
#include "common/pixel_tiles.glsl"

const float kNightBlack = 0.006;  // linear; sRGB level 20 of 255

void main() {
  FrameConstants f = frame.frame_data;
  uvec2 pixel = tile_pixel();
  if (any(greaterThanEqual(pixel, f.size))) return;
  ivec2 at = ivec2(pixel);
  float depth = texelFetch(depth_tex, at, 0).r;
  uvec2 id = texelFetch(id_tex, at, 0).rg;
  float distance_m = kFarDepth_m;
  vec4 albedo = vec4(0.0);
  vec3 normal = vec3(0.0);
  vec3 emission = vec3(0.0);
  if (id.y != 0u && depth > 0.0) {
    TerrainTile tile = tiles.at[id.y - 1u];
    vec2 uv = unpackUnorm2x16(id.x);
    vec3 dir = pixel_direction(f, vec2(pixel) + 0.5);
    distance_m = distance_from_depth(f, depth, dir);
    vec3 up = geodetic_up(f.planet, dir * distance_m);
    // Size of a texel that the pixel's footprint covers: geometric mean of its two sides, the long one limited.
    float cos_lat = max(length(up.xy), 0.1);
    float cos_view = max(abs(dot(up, dir)), 0.1);
    float footprint_m = distance_m * f.pixel_angle_rad * inversesqrt(cos_view);
    float lod = log2(max(footprint_m / (tile.texel_m * sqrt(cos_lat)), 1.0e-6));
    // A tile that has just replaced its parent shows the parent's texels (its own, one mip coarser), and sharpens as it
    // takes its own shape.
    float coarsened = 1.0 - tile.morph;
    vec4 texel = textureLod(imagery_tex,
                            vec3(terrain_atlas_coordinate(uv.x, kTerrainImageryTexels),
                                 terrain_atlas_coordinate(uv.y, kTerrainImageryTexels), float(tile.slot)),
                            clamp(lod, coarsened, float(kTerrainImageryMips) - 1.0));
    bool water = texel.a >= 0.5;
    normal = up;
    albedo = vec4(0.0, 0.0, 0.0, 2.0);
    if (!water) {
      albedo = vec4(texel.rgb, 1.0);
      vec2 slope = textureLod(slope_tex,
                              vec3(terrain_atlas_coordinate(uv.x, kTerrainSlopeTexels),
                                   terrain_atlas_coordinate(uv.y, kTerrainSlopeTexels), float(tile.slot)),
                              clamp(lod - 1.0, coarsened, float(kTerrainSlopeMips) - 1.0)).rg;
      vec3 east = vec3(-up.y, up.x, 0.0) / max(length(up.xy), 1.0e-6);
      vec3 north = cross(up, east);
      normal = normalize(up - slope.x * east - slope.y * north);
    }
    // Lights are out by day (sun more than 6 degrees up). The whole map is one small texture.
    if (dot(up, f.sun_dir) < 0.105) {
      vec2 map = tile.map_origin + uv * tile.map_size;
      float map_texel_m = 4.0075e7 / float(textureSize(night_tex, 0).x);
      emission = textureLod(night_tex, map, max(log2(max(footprint_m / map_texel_m, 1.0e-6)), 0.0)).rgb;
      // The picture's black is not black, but a level or a few of 255: over a dark sea that would outshine the sky.
      emission = max(emission - kNightBlack, vec3(0.0)) * (1.0 / (1.0 - kNightBlack));
      // Its colours are those of a JPEG's blocks: lamps, on the mean, are as warm as 3000 K.
      emission = dot(emission, vec3(0.2126, 0.7152, 0.0722)) * vec3(1.47, 0.93, 0.29);
    }
  }
  imageStore(out_depth_m, at, vec4(distance_m));
  imageStore(out_albedo, at, albedo);
  imageStore(out_normal, at, vec4(normal, 0.0));
  imageStore(out_emission, at, vec4(emission, 0.0));
}
