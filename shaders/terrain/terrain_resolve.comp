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

layout(constant_id = 0) const bool NIGHT = true;  // somewhere in view; else there is no emission

const float kNightBlack = 0.006;  // linear; sRGB level 20 of 255

// The lights' map where a texel of it covers many pixels: cubic B-spline, as four bilinear reads, so that a city is a
// soft spot and no diamond of 20 km. Weights: Sigg and Hadwiger, GPU Gems 2, ch. 20.
vec3 night_magnified(vec2 map) {
  vec2 size = vec2(textureSize(night_tex, 0));
  vec2 at = map * size - 0.5;
  vec2 f = fract(at);
  vec2 w0 = (1.0 - f) * (1.0 - f) * (1.0 - f) / 6.0, w3 = f * f * f / 6.0;
  vec2 w1 = 2.0 / 3.0 - f * f * (1.0 - 0.5 * f);
  vec2 low = w0 + w1, high = 1.0 - low;
  vec2 a = (at - f - 0.5 + w1 / low) / size, b = (at - f + 1.5 + w3 / high) / size;
  return low.y * (low.x * textureLod(night_tex, a, 0.0).rgb + high.x * textureLod(night_tex, vec2(b.x, a.y), 0.0).rgb) +
         high.y * (low.x * textureLod(night_tex, vec2(a.x, b.y), 0.0).rgb + high.x * textureLod(night_tex, b, 0.0).rgb);
}

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
    vec3 place = vec3(tile.atlas_origin + uv * tile.atlas_size, float(tile.slot));
    float colour_lod = terrain_colour_lod(lod, tile.detail_log2, coarsened * (1.0 - tile.parts));
    float coast_lod = clamp(lod, coarsened, float(kTerrainImageryMips) - 1.0);
    vec4 texel = textureLod(imagery_tex, place, colour_lod);
    // Coasts may have more detail than colours have.
    if (coast_lod != colour_lod) texel.a = textureLod(imagery_tex, place, coast_lod).a;
    bool water = texel.a >= 0.5;
    normal = up;
    albedo = vec4(0.0, 0.0, 0.0, 2.0);
    if (!water) {
      // Between the source's pixels lie its codes, as they do for GDAL; their albedo comes after.
      albedo = vec4(terrain_linear(texel.r), terrain_linear(texel.g), terrain_linear(texel.b), 1.0);
      vec2 slope = textureLod(slope_tex,
                              vec3(terrain_slope_coordinate(uv.x), terrain_slope_coordinate(uv.y), float(tile.slot)),
                              clamp(lod + tile.slope_lod, coarsened, float(kTerrainSlopeMips) - 1.0)).rg;
      vec3 east = vec3(-up.y, up.x, 0.0) / max(length(up.xy), 1.0e-6);
      vec3 north = cross(up, east);
      normal = normalize(up - slope.x * east - slope.y * north);
    }
    // Lights are out by day (sun more than 6 degrees up). The whole map is one small texture.
    if (NIGHT && dot(up, f.sun_dir) < 0.105) {
      vec2 map = tile.map_origin + uv * tile.map_size;
      float map_texel_m = 4.0075e7 / float(textureSize(night_tex, 0).x);
      float night_lod = log2(max(footprint_m / map_texel_m, 1.0e-6));
      emission = textureLod(night_tex, map, max(night_lod, 0.0)).rgb;
      // From one texel a pixel to two pixels a texel the one becomes the other.
      if (night_lod < 0.0) emission = mix(emission, night_magnified(map), clamp(-night_lod, 0.0, 1.0));
      // The picture's black is not black, but a level or a few of 255: over a dark sea that would outshine the sky.
      emission = max(emission - kNightBlack, vec3(0.0)) * (1.0 / (1.0 - kNightBlack));
      // Its colours are those of a JPEG's blocks: lamps, on the mean, are as warm as 3000 K.
      emission = dot(emission, vec3(0.2126, 0.7152, 0.0722)) * vec3(1.47, 0.93, 0.29);
    }
  }
  imageStore(out_depth_m, at, vec4(distance_m));
  imageStore(out_albedo, at, albedo);
  imageStore(out_normal, at, vec4(normal, 0.0));
  if (NIGHT) imageStore(out_emission, at, vec4(emission, 0.0));
}
