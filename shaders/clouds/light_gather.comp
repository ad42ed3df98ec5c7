#version 460
#extension GL_GOOGLE_include_directive : require
// What a droplet in each seen cell would send to the camera of light that was scattered before: paths backwards from the cell.
// The first direction is drawn from the true phase function; from there on the medium is the similarity-scaled one (delta-M,
// Wiscombe 1977): the share f of scattering goes straight on, the rest has the asymmetry g*. docs/light.md has the derivation.
// The same for the ground under each node: illuminance by scattered light, as shares of key light, sky light and lit ground.
// In a still each thread has a cell. In sequences each has a path: few cells want any, and what is before counts on.
#include "clouds/clouds_shared.h"
#include "common/frame.h"
#include "common/random.h"
#include "common/sampling.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
layout(scalar, set = 0, binding = 1) uniform CloudBlock { CloudConstants cloud_data; } cloud;
#define CLOUD cloud.cloud_data
#define CLOUD_PLANET frame.frame_data.planet
layout(set = 0, binding = 2) uniform sampler3D grid_tex;
layout(set = 0, binding = 9) uniform sampler3D most_tex;
#include "clouds/cloud_grid.glsl"
#include "clouds/light_cells.glsl"
layout(scalar, set = 0, binding = 3) uniform LightBlock { CloudLightConstants data; } light;
layout(scalar, set = 0, binding = 4) readonly buffer WorkBlock { LightWork data; } work;
layout(scalar, set = 0, binding = 5) readonly buffer ListBlock { uint at[]; } list;        // of cells; sequences: of those without light
layout(scalar, set = 0, binding = 16) readonly buffer RefreshBlock { uint at[]; } refresh;  // sequences: of those that get a path more
layout(set = 0, binding = 6, rgba16f) uniform image3D out_cells;
layout(set = 0, binding = 10) uniform sampler2D sky_tex;   // of light_sky.comp
layout(set = 0, binding = 11) uniform sampler2D depth_m;
layout(set = 0, binding = 12, rgba32f) uniform image2D out_ground;
layout(set = 0, binding = 15, r32f) uniform image2D out_weight;  // of nodes on the ground, in full sets of paths
layout(constant_id = 0) const uint KIND = 0u;
const bool SURFACE = (KIND & 1u) != 0u;  // false: cells; true: what falls on the ground at the nodes
const bool SEQUENCE = KIND >= 2u;        // true: a thread has a path
#define TERRAIN_VOLUME_BINDING 13  // and 14
#define TERRAIN_CONSTANT 1
#include "terrain/terrain_air.glsl"
#define GROUND_MAP_BINDING 7  // and 8
#include "terrain/ground_map.glsl"

const int kMostTurns = 40000;
const float kRouletteBelow = 0.3;
const int kMostVertices = 1000;   // what goes on for longer is lost in thick cloud
const float kWaterAlbedo = 0.06;  // of a sea, diffuse light, all angles (Jin et al. 2004)

float ground_distance(Flight f) {
  float t = distance_to_shell(f, scaled_height_from_geodetic(CLOUD_PLANET, f.q0, ground_height_m(light.data.ground, normalize(f.q0))));
  vec3 q = f.q0 + f.scaled_dir * min(t, 1.0e6);
  return distance_to_shell(f, scaled_height_from_geodetic(CLOUD_PLANET, q, ground_height_m(light.data.ground, normalize(q))));
}

// The sky's light from a direction, in shares of an even sky.
float sky_share(vec3 up, vec3 dir, vec3 sun) {
  float mu = clamp(dot(up, dir), 0.0, 1.0);
  vec3 a = dir - up * dot(up, dir), b = sun - up * dot(up, sun);
  float c = dot(a, b) * inversesqrt(max(dot(a, a) * dot(b, b), 1.0e-12));
  return textureLod(sky_tex, vec2(acos(clamp(c, -1.0, 1.0)) / kPi, sqrt(mu)), 0.0).r;
}

// Transmittance of the medium itself through clumps of mean optical depth `tau`, whose scaled medium (its extinction is `rest`
// of theirs) lets `scaled` through: a share c of the way is barred by clumps of depth tau / c, found by halving.
float clump_transmittance(float tau, float rest, float scaled) {
  float low = 0.0, high = 1.0;
  for (int i = 0; i < 10; ++i) {
    float c = 0.5 * (low + high);
    if (c * (1.0 - exp(-rest * tau / c)) < 1.0 - scaled) low = c;
    else high = c;
  }
  return 1.0 - high * (1.0 - exp(-tau / high));
}

shared vec3 partial[kLightThreads];

void main() {
  uint item = gl_GlobalInvocationID.x;
  uint cell = item;
  // Paths: from `path` to `last`; `threads` neighbours share a cell.
  uint path = 0u, last = light.data.cells.paths, threads = 1u;
  bool wanted = true, full = true;
  if (SEQUENCE) {
    uint first = light_threads(light.data.cells), group = gl_WorkGroupID.y * kLightGroupsAcross + gl_WorkGroupID.x;
    uint fresh_count = SURFACE ? work.data.ground_fresh : work.data.fresh, fresh_groups = light_groups(fresh_count, first);
    full = group < fresh_groups;
    threads = full ? first : 1u;
    uint each = kLightThreads / threads, slot = gl_LocalInvocationID.x / threads;
    item = (full ? group : group - fresh_groups) * each + slot;
    wanted = slot < each && item < (full ? fresh_count : SURFACE ? work.data.ground_refresh : work.data.refresh);
    cell = !wanted ? 0u : full ? list.at[item] : refresh.at[item];
    if (SURFACE) cell *= light.data.cells.slices;
    path = full ? gl_LocalInvocationID.x % threads : 0u;
    last = path + 1u;
  } else if (SURFACE) {
    if (item >= light.data.cells.nodes.x * light.data.cells.nodes.y) return;
    cell = item * light.data.cells.slices;
  } else {
    if (item >= work.data.count) return;
    cell = list.at[item];
  }
  FrameConstants f = frame.frame_data;
  LightCells cells = light.data.cells;
  CloudGrid grid = light.data.grid;
  uint slice = cell % cells.slices, column = cell / cells.slices;
  uvec2 node = uvec2(column % cells.nodes.x, column / cells.nodes.x);
  vec3 dir = light_node_direction(f, cells, node);
  float entry = light_entry(f.planet, grid, dir);
  vec3 sum = vec3(0.0);  // of the key light, of the sky, of the lit ground, 1/sr
  float valid = entry >= 0.0 && wanted ? 1.0 : 0.0;
  vec3 origin = dir * (max(entry, 0.0) + light_slice_m(cells, float(slice) + 0.5));
  vec3 sun = f.key_dir, normal = dir;
  float rest = 1.0 - light.data.forward_albedo;  // of the extinction, in the scaled medium
  float distance_m = 0.0;
  if (SURFACE) {
    ivec2 pixel = min(ivec2((vec2(node) + 0.5) * vec2(f.size) / vec2(cells.nodes)), ivec2(f.size) - 1);
    distance_m = texelFetch(depth_m, pixel, 0).r;
    valid = distance_m < 0.5 * kFarDepth_m && wanted ? 1.0 : 0.0;
    dir = pixel_direction(f, vec2(pixel) + 0.5);
    normal = geodetic_up(f.planet, dir * distance_m);
    origin = dir * distance_m + normal;
  }
  // Paths that come one in a while go on where the last ones of the cell ended.
  Random random = random_stream(cell, full ? light.data.frame_index : 0u, light.data.seed);
  vec2 shift = vec2(random_unit(random), random_unit(random));
  if (SEQUENCE) {
    random = random_stream(cell, light.data.frame_index, light.data.seed ^ ((path + 1u) * 0x85ebca6bu));
    if (!full) shift = fract(shift + float((light.data.frame_index / cells.refresh_frames) & 0xfffu) * vec2(0.7548777, 0.5698403));
  }

  bool alive = false;
  Flight flight = flight_from(origin, dir);
  Place here;
  float weight = 0.0, above_m, below_m;
  int band = -1, vertices = 0;
  for (int turn = 0; turn < kMostTurns && valid > 0.0; ++turn) {
    bool begin = false;
    vec3 start = vec3(0.0), way = vec3(0.0);
    if (!alive) {
      if (path == last) break;
      // Stratified over the angle, golden steps about it.
      uint stratum = path * cells.path_step % cells.paths;
      vec2 u = vec2((float(stratum) + shift.x) / float(cells.paths), fract(shift.y + 0.618034 * float(stratum)));
      if (SEQUENCE && !full) u = shift;
      way = SURFACE ? sample_cosine_hemisphere(normal, u) : direction_about(dir, sample_lobes_cosine(CLOUD.phase, u.x), u.y);
      start = origin;
      weight = 1.0;
      vertices = 0;
      alive = begin = true;
      ++path;
    } else {
      // On to the next tentative collision; or as far as the majorant holds, or over a gap between bands.
      float climb = dot(flight.dir, here.up);
      float reach = grid_leap(grid, band, here.height_m, above_m, below_m, climb);
      bool tentative = false;
      float majorant = 0.0;
      if (band >= 0) {
        majorant = rest * grid_most(grid, band, here, climb, reach);
        float draw = -log(1.0 - random_unit(random));
        if (draw < majorant * reach) {
          tentative = true;
          reach = max(draw / majorant, 0.01);
        }
      }
      flight.s += reach;
      vec2 draw = vec2(random_unit(random), random_unit(random));
      float chance = random_unit(random), stay = 1.0;
      if (flight.s >= flight.end_m) {
        if (flight.end_m >= kFar_m) {
          sum.y += weight / kPi * sky_share(place_on(flight_from(flight.origin, flight.dir)).up, flight.dir, sun);
          alive = false;
        } else {
          flight.s = flight.end_m;
          here = place_on(flight);
          vec3 p = flight.origin + flight.dir * flight.s;
          GroundPoint ground = ground_at(light.data.ground, here.dir);
          weight *= mix(dot(ground.albedo, vec3(0.2126, 0.7152, 0.0722)), kWaterAlbedo, ground.water);
          sum.z += weight / kPi * exp(-rest * grid_sun_depth(grid, p, sun).y) * terrain_air_share(p);
          begin = true;
          start = p + here.up;
          way = sample_cosine_hemisphere(here.up, draw);
        }
      } else {
        here = place_on(flight);
        band = grid_band(grid, here.height_m, above_m, below_m);
        if (tentative && band >= 0) {
          vec4 medium = grid_read(grid, band, here);
          if (chance * majorant < rest * medium.x) {
            weight *= light.data.wide_albedo;
            sum.x += weight * phase_hg(dot(flight.dir, sun), light.data.wide_g) * exp(-rest * min(medium.y, medium.w)) * terrain_air_share(flight.origin + flight.dir * flight.s);
            begin = true;
            start = flight.origin + flight.dir * flight.s;
            way = direction_about(flight.dir, sample_hg_cosine(light.data.wide_g, draw.x), draw.y);
          }
        }
      }
      if (begin && ++vertices > kMostVertices) alive = false;
      if (alive && begin && weight < kRouletteBelow) {
        alive = random_unit(random) < weight / kRouletteBelow;
        weight = kRouletteBelow;
      }
    }
    if (begin) {
      flight = flight_from(start, way);
      here = place_on(flight);
      if (dot(here.up, way) < 0.0) flight.end_m = ground_distance(flight);
      band = grid_band(grid, here.height_m, above_m, below_m);
    }
  }
  if (SEQUENCE) {
    // In the paths' order: sums of floats depend on it.
    partial[gl_LocalInvocationID.x] = sum;
    barrier();
    if (!wanted || gl_LocalInvocationID.x % threads != 0u) return;
    sum = vec3(0.0);
    for (uint i = 0u; i < threads; ++i) sum += partial[gl_LocalInvocationID.x + i];
    sum /= float(threads);
  } else {
    sum /= float(max(path, 1u));
  }
  if (SURFACE) {
    sum *= kPi;
    // Light that went nearly straight on falls as if it came from the light itself; that which met nothing is the shadow maps'.
    vec2 tau = grid_sun_depth(grid, origin, sun);
    float scaled = exp(-rest * tau.y);
    sum.x += max(dot(normal, sun), 0.0) * max(scaled - clump_transmittance(tau.x, rest, scaled), 0.0) * terrain_air_share(origin);
  } else {
    sum.x *= CLOUD.multiple_scattering_weight;
  }
  float weight_now = valid;
  if (SEQUENCE) {
    vec4 known = SURFACE ? vec4(imageLoad(out_ground, ivec2(node)).rgb, imageLoad(out_weight, ivec2(node)).r) : imageLoad(out_cells, ivec3(node, slice));
    float added = valid * float(threads) / float(cells.paths);
    weight_now = known.a + added;
    sum = weight_now > 0.0 ? (known.rgb * known.a + sum * added) / weight_now : vec3(0.0);
  }
  if (SURFACE) {
    imageStore(out_ground, ivec2(node), vec4(sum, distance_m));
    imageStore(out_weight, ivec2(node), vec4(weight_now));
  } else {
    imageStore(out_cells, ivec3(node, slice), vec4(sum, weight_now));
  }
}
