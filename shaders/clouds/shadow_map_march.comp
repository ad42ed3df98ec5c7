#version 460
#extension GL_GOOGLE_include_directive : require
// Marches tiles of the clouds' shadow maps, one group a tile: along the light through the density, with footprints of a
// texel. First the group finds out which pieces of the way may hold cloud at all, for blocks of 4 x 4 texels and with
// footprints of a block; then each texel marches through those pieces (docs/light.md, 'Shadow maps').
#include "clouds/shadow_map_shared.h"
#include "common/frame.h"
layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_density.glsl"
#include "clouds/flight.glsl"
layout(scalar, set = 0, binding = 20) uniform ShadowBlock { ShadowMaps data; } cloud_shadow;
layout(scalar, set = 0, binding = 21) readonly buffer TileBlock { ShadowTileWork at[]; } tiles;
layout(set = 0, binding = 22, rgba32ui) uniform uimage2DArray shadow_map;
layout(constant_id = 5) const uint DETAIL = 1u;   // noises besides the fields: 1 billows, 2 turbulence as well, 3 all
layout(constant_id = 6) const bool MERGE = false; // the mean with what the texels hold already
layout(push_constant, scalar) uniform PushBlock { uint first; float step_scale; float footprint; } push;

const float kSunwards_m = 60.0e3;  // clouds further towards the light than this from everything in view are left out
const float kBillowReach = 0.60;   // most that billows add to a level, but for rare peaks
const float kSlack = 0.15;         // change of a level's resolved part within a block
const float kLevelApart = 0.16;    // a level of -1 is about this many cells from a cloud, at least
const int kMostSteps = 160;

shared uint pieces[8];  // per block two words: pieces that may hold cloud

// The way of a light ray between the shells that hold all casting layers, as heights z over the plane: down from top to
// inner_top; and, past its nearest point to the Earth, where that is above the ground, on from inner_bottom to bottom.
struct LightWay { float top, first_m, inner_bottom, second_m; };

// Heights z at which a ray crosses a shell, x the one nearer to the light; false: never.
bool shell_roots(Flight f, float shell_m, out vec2 z) {
  float b = 0.5 * f.slope, c = f.f0 - shell_m * (2.0 * CLOUD_PLANET.a_m + shell_m);
  float d = b * b - f.bend * c;
  z = vec2(0.0);
  if (d < 0.0) return false;
  float root = sqrt(d);
  z = b > 0.0 ? vec2(-c / (b + root), -(b + root) / f.bend) : vec2((root - b) / f.bend, c / (root - b));
  return true;
}

LightWay light_way(Flight f, ShadowCascade cascade) {
  // Scaled height is up to 1.00336 times the geodetic one: the shells are taken that much apart.
  float low_m = cloud_shadow.data.hull_low_m, high_m = cloud_shadow.data.hull_high_m * 1.0034 + 1.0;
  low_m -= max(-low_m, 0.0) * 0.0034 + 1.0;
  LightWay way = LightWay(0.0, 0.0, 0.0, 0.0);
  vec2 outer, inner, ground;
  if (!shell_roots(f, high_m, outer)) return way;
  float end = outer.y, resume = outer.y;
  if (shell_roots(f, low_m, inner)) {
    end = inner.x;
    resume = shell_roots(f, -500.0, ground) ? outer.y : inner.y;
  }
  way.top = min(outer.x, cascade.high_m + kSunwards_m);
  way.first_m = max(way.top - max(end, cascade.low_m), 0.0);
  way.inner_bottom = min(resume, cascade.high_m + kSunwards_m);
  way.second_m = max(way.inner_bottom - max(outer.y, cascade.low_m), 0.0);
  return way;
}

// Whether a layer casts shadows. Layers are gone through by their own number: with a single one all of its data is then at
// addresses that the compiler knows.
bool casts(uint l) {
  if (LAYERS == 1u) return true;
  bool some = false;
  for (uint k = 0u; k < kCloudLayers; ++k) some = some || (k < CLOUD.caster_count && CLOUD.casters[k] == l);
  return some;
}

float way_z(LightWay way, float u) { return u < way.first_m ? way.top - u : way.inner_bottom - (u - way.first_m); }

// Length of a ray over which height changes by dz, where it climbs by `climb` per metre.
float ray_over(float dz_m, float climb) { return 2.0 * dz_m / (climb + sqrt(climb * climb + 2.0 * dz_m / CLOUD_PLANET.a_m)); }

CloudWeather mix_weather(CloudWeather a, CloudWeather b, float u) {
  return CloudWeather(mix(a.coverage, b.coverage, u), mix(a.properties, b.properties, u), mix(a.ground_m, b.ground_m, u));
}

// False where no cloud of layer l can be within the footprint between two heights.
bool may_hold(uint l, CloudWeather w, vec3 p, vec3 up, float height_m, vec2 heights_m, float log2_footprint) {
  float slope_m = GROUND || WEATHER != kWeatherUniform ? 0.04 * exp2(log2_footprint) : 1.0;
  float thickness = CLOUD.layers[l].thickness_m, base_m = cloud_base_m(l, w);
  vec2 eta = (heights_m + vec2(-slope_m, slope_m) - base_m) / thickness;
  bool outside = eta.y <= 0.0 || eta.x >= 1.0;
  eta = clamp(eta, 0.02, 1.0);
  CloudColumn c = cloud_column(l, w, p, up, height_m, log2_footprint);
  float widest = clamp(exp2(-1.0 / CLOUD.layers[l].altering_bias), eta.x, eta.y), least = 1.0e9;
  for (int i = 0; i < 4; ++i) least = min(least, cell_threshold(cloud_need(l, c, i < 3 ? mix(eta.x, eta.y, 0.5 * float(i)) : widest), c.probit));
  float unknown = c.unknown;
  float level = cloud_cell_field(l, c, p, up, clamp(height_m, base_m, base_m + thickness), log2_footprint, unknown) - least;
  float reach = level + (kBillowReach * CLOUD.layers[l].shape_amount + 0.2 * CLOUD.layers[l].detail_amount) * smoothstep(0.0, 0.25, eta.y) + 2.6 * sqrt(unknown) + kSlack;
  return !outside && reach > 0.0;
}

Flight ray_of(ShadowCascade cascade, vec2 texel) {
  vec2 aside = texel * cascade.texel_m;
  return flight_from(cascade.corner + cloud_shadow.data.axis_x * aside.x + cloud_shadow.data.axis_y * aside.y, cloud_shadow.data.light);
}

// Optical depth first, then where it was reached: one march of a texel.
ShadowTexel march_texel(ShadowCascade cascade, vec2 texel, uvec2 todo, float jitter) {
  Flight f = ray_of(cascade, texel);
  LightWay way = light_way(f, cascade);
  float total = way.first_m + way.second_m, slab_m = total / float(cascade.slabs);
  float footprint_m = max(push.footprint * cascade.texel_m, 1.0), log2_footprint = log2(footprint_m);
  CloudWeather w0, w1;
  for (int i = 0; i < 2; ++i) {
    vec3 p = f.origin + f.dir * way_z(way, float(i) * total);
    CloudWeather w = cloud_weather_at(p, geodetic_up(CLOUD_PLANET, p), log2_footprint);
    w0 = i == 0 ? w : w0;
    w1 = w;
  }
  float shortest = 1.0e9;
  for (uint l = 0u; l < LAYERS; ++l)
    if (casts(l)) shortest = min(shortest, CLOUD.layers[l].step_m);
  float knots[6] = float[6](1.0e9, 1.0e9, 1.0e9, 1.0e9, 1.0e9, 1.0e9);
  float tau = 0.0, behind = 0.0, end_u = 0.0, u = 0.0, fine = shortest;
  int steps = 0;
  while (steps < kMostSteps && u < total && min(tau, behind) < kShadowDeepest) {
    ++steps;
    // On to the next piece that may hold cloud.
    uint slab = min(uint(u / slab_m), cascade.slabs - 1u);
    uint low = slab < 32u ? todo.x >> slab : 0u, high = slab < 32u ? todo.y : todo.y >> (slab - 32u);
    uint next = low != 0u ? slab + uint(findLSB(low)) : high != 0u ? max(slab, 32u) + uint(findLSB(high)) : 999u;
    if (next > slab) u = float(next) * slab_m;
    float at = min(u + jitter * fine, total);
    f.s = way_z(way, at);
    Place here = place_on(f);
    vec3 p = f.origin + f.dir * f.s;
    float climb = abs(dot(here.up, f.dir));
    CloudWeather w = mix_weather(w0, w1, at / max(total, 1.0));
    float sigma = 0.0, clumped = 0.0, advance_m = slab_m;
    for (uint l = 0u; l < LAYERS; ++l) {
      if (!casts(l)) continue;
      CloudColumn c = cloud_column(l, w, p, here.up, here.height_m, log2_footprint);
      float eta = cloud_eta(l, c, here.height_m);
      float own = clamp(0.7 * cascade.texel_m, CLOUD.layers[l].step_m, max(ray_over(CLOUD.layers[l].thickness_m, climb) * 0.1, CLOUD.layers[l].step_m)) * (1.2 * push.step_scale);
      float unknown = c.unknown;
      float level = cloud_cell_field(l, c, p, here.up, here.height_m, log2_footprint, unknown);
      level -= cell_threshold(cloud_need(l, c, clamp(eta, 0.0, 1.0)), c.probit);
      CloudChurn churn = CloudChurn(vec3(0.0), vec3(0.0), vec3(0.0));
      if (DETAIL > 1u) churn = cloud_churn(l, p, here.up, eta, log2_footprint);
      level += cloud_shape_level(l, c, churn, p, eta, log2_footprint, unknown);
      if (DETAIL > 2u) level += cloud_detail_level(l, c, churn, p, eta, log2_footprint, unknown);
      else unknown += kDetailWeight * kDetailWeight * CLOUD.layers[l].detail_amount * CLOUD.layers[l].detail_amount;
      CloudMedium medium = cloud_medium(l, c.density, level, unknown, 0.0, eta, footprint_m);
      float s = medium.mean_per_m;
      if (eta > 0.0 && eta < 1.0) {
        sigma += s;
        clumped += medium.sigma_per_m;
        float apart = kLevelApart * CLOUD.layers[l].cell_size_m;
        float step_m = s > 0.0 ? (tau > 2.0 ? 2.0 * own : own) : clamp(-level * apart - kBillowReach * CLOUD.layers[l].shape_amount * apart, own, 4.0 * own);
        advance_m = min(advance_m, step_m);
        fine = own;
      }
    }
    float step_m = min(advance_m, total - u);
    if (u < total && sigma > 0.0) {
      float per = 1.0 / sigma, after = tau + sigma * step_m;
      if (tau == 0.0) knots[0] = u;
      for (int i = 1; i < 6; ++i) {
        float t = shadow_knot(i);
        if (tau < t && after >= t) knots[i] = u + (t - tau) * per;
      }
      tau = after;
      behind += clumped * step_m;
      end_u = u + step_m;
    }
    u += max(step_m, 0.5);
  }
  ShadowTexel result;
  // Depths along the light: past the gap below the shells they go on, as z does.
  float zero = 32768.0, unit = 1.0 / cascade.depth_unit_m;
  float before = 0.0;
  for (int i = 0; i < 6; ++i) {
    float t = shadow_knot(i), t0 = i == 0 ? 0.0 : shadow_knot(max(i - 1, 0));
    float x = zero - way_z(way, knots[i]) * unit;
    float end_x = zero - way_z(way, end_u) * unit;
    bool reached = knots[i] < 1.0e9;
    // The first that is never reached: on the line to the end.
    float beyond = tau > t0 + 1.0e-5 && i > 0 ? before + (end_x - before) * (t - t0) / (tau - t0) : 65535.0;
    result.at[i] = reached ? x : tau > t0 ? beyond : 65535.0;
    before = clamp(reached ? x : 0.0, 0.0, 65535.0);
  }
  result.depth = min(behind, kShadowDeepest);
  result.end = zero - way_z(way, end_u) * unit;
  return result;
}

// The transmittances' mean of two texels, as a texel.
ShadowTexel merge(uvec4 old, uvec4 fresh, float share) {
  ShadowTexel result;
  float end_old = float(old.w >> 16u), end_fresh = float(fresh.w >> 16u);
  bool some_old = (old.w & 0xffffu) != 0u, some_fresh = (fresh.w & 0xffffu) != 0u;
  result.end = max(some_old ? end_old : 0.0, some_fresh ? end_fresh : 0.0);
  result.depth = min(-log(mix(exp(-shadow_depth_at(old, 65535.0)), exp(-shadow_depth_at(fresh, 65535.0)), share)), kShadowDeepest);
  float whole = -log(mix(exp(-shadow_depth_at(old, result.end - 1.0)), exp(-shadow_depth_at(fresh, result.end - 1.0)), share));
  float before = 0.0;
  for (int i = 0; i < 6; ++i) {
    // By 16 halvings.
    float t = shadow_knot(i), t0 = i == 0 ? 0.0 : shadow_knot(max(i - 1, 0)), wanted = max(t, 0.004);
    float low = 0.0, high = result.end;
    for (int k = 0; k < 16; ++k) {
      float x = 0.5 * (low + high);
      float depth = -log(mix(exp(-shadow_depth_at(old, x)), exp(-shadow_depth_at(fresh, x)), share));
      if (depth < wanted) low = x;
      else high = x;
    }
    bool reached = whole >= wanted;
    float beyond = i > 0 && whole > t0 + 1.0e-3 ? before + (result.end - before) * (t - t0) / (whole - t0) : 65535.0;
    result.at[i] = reached ? high : beyond;
    before = reached ? high : 0.0;
  }
  return result;
}

void main() {
  ShadowTileWork tile = tiles.at[push.first + gl_WorkGroupID.x];
  ShadowCascade cascade = cloud_shadow.data.at[tile.cascade];
  uint lane = gl_LocalInvocationIndex;
  uvec2 first = uvec2(tile.x, tile.y) * kShadowTile;
  if (lane < 8u) pieces[lane] = 0u;
  barrier();
  for (uint i = lane; i < 4u * cascade.slabs; i += 64u) {
    uint block = i & 3u, slab = i >> 2;
    Flight f = ray_of(cascade, vec2(first) + vec2(block & 1u, block >> 1) * 4.0 + 2.0);
    LightWay way = light_way(f, cascade);
    float total = way.first_m + way.second_m, slab_m = total / float(cascade.slabs);
    float log2_footprint = log2(max(max(4.0 * cascade.texel_m, 0.7 * slab_m), 1.0));
    vec2 heights = vec2(0.0);
    for (int k = 0; k < 2; ++k) {
      f.s = way_z(way, (float(slab) + float(k)) * slab_m);
      heights[k] = place_on(f).height_m;
    }
    heights = vec2(min(heights.x, heights.y), max(heights.x, heights.y));
    f.s = way_z(way, (float(slab) + 0.5) * slab_m);
    Place here = place_on(f);
    vec3 p = f.origin + f.dir * f.s;
    CloudWeather w = cloud_weather_at(p, here.up, log2_footprint);
    bool some = false;
    for (uint l = 0u; l < LAYERS; ++l)
      if (casts(l) && may_hold(l, w, p, here.up, here.height_m, heights, log2_footprint)) some = true;
    if (some && total > 0.0) atomicOr(pieces[2u * block + (slab >> 5)], 1u << (slab & 31u));
  }
  barrier();
  // Eight lanes in a row are half a block: they march in step.
  uint block = lane >> 4;
  uvec2 within = uvec2(lane & 3u, (lane >> 2) & 3u) + uvec2(block & 1u, block >> 1) * 4u;
  uvec2 todo = uvec2(pieces[2u * block], pieces[2u * block + 1u]);
  uvec2 texel = first + within;
  // Later rounds move along the way and within the texel's inner half (R2 sequence, Roberts 2018): all of it would blur edges
  // that lookups blur already.
  float n = float(tile.round);
  vec2 inside = 0.25 + 0.5 * fract(vec2(0.5) + n * vec2(0.7548777, 0.5698403));
  float jitter = fract(0.5 + n * 0.6180340);
  uvec4 packed = shadow_pack(march_texel(cascade, vec2(texel) + inside, todo, jitter));
  ivec3 place = ivec3(shadow_place(cascade, texel, cloud_shadow.data.resolution), tile.cascade);
  if (MERGE) packed = shadow_pack(merge(imageLoad(shadow_map, place), packed, 1.0 / (n + 1.0)));
  imageStore(shadow_map, place, packed);
}
