#version 460
#extension GL_GOOGLE_include_directive : require
// The path tracer: radiance without bias, by delta tracking (Woodcock 1965) over the density of cloud_density.glsl at full detail,
// with the key light at every vertex by ratio tracking (Novak et al. 2014). docs/reference.md has the estimators.
//
// Every invocation takes path after path from a counter. One turn of its loop moves it along its flight, through majorants that
// are piecewise constant, to the next tentative collision, and asks for the density there once: paths of all kinds and lengths
// keep each other busy. What a path brought home depends on (pixel, sample, seed) alone, not on who traced it.
#include "clouds/path_shared.h"
#include "common/frame.h"
#include "common/random.h"
#include "common/sampling.h"
#include "common/water.h"
layout(local_size_x = 64) in;

layout(constant_id = 0) const uint MODE = 0u;
const uint kPicture = 0u;  // pixels of a frame, over its ground
const uint kFurnace = 1u;  // light comes evenly from all sides: no sun, no ground
const uint kTable = 2u;    // rays of a table; the key light's illuminance is 1

layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_density.glsl"
layout(set = 0, binding = 11) uniform sampler3D bounds_tex;
layout(scalar, set = 0, binding = 12) uniform SceneBlock { CloudBounds bounds; RegionMap ground; } scene;
layout(set = 0, binding = 13) uniform sampler2D surface_depth;   // of the frame: m along the ray
layout(set = 0, binding = 14) uniform sampler2D surface_albedo;  // a: 0 sky, 1 land, 2 water
layout(set = 0, binding = 15) uniform sampler2D surface_normal;
layout(set = 0, binding = 16) uniform sampler2D key_tex;         // illuminance of the key light over (mu, height)
#define GROUND_MAP_BINDING 17  // and 18
#include "terrain/ground_map.glsl"
#include "clouds/flight.glsl"
layout(scalar, set = 0, binding = 20) buffer WorkBlock { PathWork data; } work;
layout(scalar, set = 0, binding = 21) writeonly buffer ResultBlock { PathResult at[]; } results;
layout(scalar, set = 0, binding = 22) readonly buffer RayBlock { PathRay at[]; } rays;
layout(scalar, set = 0, binding = 24) readonly buffer PlanBlock { PathPlan at[]; } plan;
layout(scalar, set = 0, binding = 23) buffer LaneBlock { PathLane at[]; } lanes;
layout(constant_id = 16) const uint TURNS = 0u;  // of an invocation's loop; 0: until there is nothing to do
layout(push_constant, scalar) uniform PushBlock { PathPush push; };

const float kRouletteBelow = 0.3;   // weights below are gambled up to it
const float kShadowBelow = 0.25;    // the same of a shadow's transmittance
const float kGuide = 0.3;           // chance of a scattering to send a second path out towards the key light
const float kGuideWidth = 0.8;      // asymmetry of the lobe that it is drawn from
const float kNarrow = 0.9;          // droplets' forward lobes narrower than this are that lobe themselves
const float kGuideSecond = 1.0;     // then: chance of a scattering of the second path to be offered a way towards the light
const float kGuideValue = 0.2;      // of its choice: how much a way towards the light is worth, over isotropic scattering there
const float kShadowOf = 0.2;       // of the light, 1/sr: vertices that would send less are gambled up to it
const float kLeastShadows = 0.1;
const int kMoves = 12;              // along a flight in one turn

// Where a flight of scattered light meets the ground: a smooth shell at the ground map's height there.
float distance_to_ground_map(Flight f) {
  float t = distance_to_shell(f, scaled_height_from_geodetic(CLOUD_PLANET, f.q0, ground_height_m(scene.ground, normalize(f.q0))));
  vec3 q = f.q0 + f.scaled_dir * min(t, 1.0e6);
  return distance_to_shell(f, scaled_height_from_geodetic(CLOUD_PLANET, q, ground_height_m(scene.ground, normalize(q))));
}

// The majorant where a flight is, and how far it holds.
float bound_along(Flight f, out float reach_m) {
  Place p = place_on(f);
  float climb = dot(f.dir, p.up);
  float above_m = kFar_m, below_m = kFar_m;  // to the next boundary of height
  int slice = -1;
  float step_m = 0.0;
  for (uint b = 0u; b < scene.bounds.bands; ++b) {
    float low = scene.bounds.band_low_m[b], high = scene.bounds.band_high_m[b];
    if (p.height_m < low) {
      above_m = min(above_m, low - p.height_m);
    } else if (p.height_m >= high) {
      below_m = min(below_m, p.height_m - high);
    } else {
      float slices = scene.bounds.band_slices[b];
      step_m = (high - low) / slices;
      float i = min(floor((p.height_m - low) / step_m), slices - 1.0);
      slice = int(scene.bounds.band_first[b] + i);
      above_m = low + (i + 1.0) * step_m - p.height_m;
      below_m = p.height_m - (low + i * step_m);
    }
  }
  float sigma = 0.0;
  reach_m = kFar_m;
  if (slice >= 0) {
    RegionMap map = scene.bounds.map;
    vec2 xy = region_xy(map, p.dir);
    // region_level() without its loop.
    uint level = uint(max(floor(log2(max(max(abs(xy.x), abs(xy.y)) / map.half_m, 0.5))) + 1.0, 0.0));
    if (level < map.levels) {
      // Velocity on the map, per metre of the flight.
      vec3 turn = (f.scaled_dir - p.dir * dot(p.dir, f.scaled_dir)) * p.inv_q;
      float open = 1.0 + dot(p.dir, map.centre);
      vec2 flat_v = map.radius_m * sqrt(2.0 / open) *
                    (vec2(dot(turn, map.east), dot(turn, map.north)) -
                     (0.5 * dot(turn, map.centre) / open) * vec2(dot(p.dir, map.east), dot(p.dir, map.north)));
      // The coarser level first: where it is empty, it reaches further.
      uint coarse = min(level + 2u, map.levels - 1u);
      float per_m = 0.5 * float(kBoundsTexels) / region_half_m(map, coarse);
      vec2 g = xy * per_m + 0.5 * float(kBoundsTexels);
      sigma = texelFetch(bounds_tex, ivec3(clamp(ivec2(g), ivec2(0), ivec2(kBoundsTexels - 1u)), int(coarse * kBoundsSlices) + slice), 0).r;
      if (sigma > 0.0 && coarse != level) {
        per_m = 0.5 * float(kBoundsTexels) / region_half_m(map, level);
        g = xy * per_m + 0.5 * float(kBoundsTexels);
        sigma = texelFetch(bounds_tex, ivec3(clamp(ivec2(g), ivec2(0), ivec2(kBoundsTexels - 1u)), int(level * kBoundsSlices) + slice), 0).r;
      }
      vec2 v = flat_v * per_m;
      vec2 inside = g - floor(g);
      vec2 edge = mix(inside, 1.0 - inside, greaterThan(v, vec2(0.0)));
      vec2 t = edge / max(abs(v), vec2(1.0e-9));
      reach_m = min(t.x, t.y) + 0.01 / max(max(abs(v.x), abs(v.y)), 1.0e-9);
      if (sigma < 0.0) {
        float run = -sigma - 1.0, over = floor(run / kBoundsRun);
        above_m += over * step_m;
        below_m += (run - over * kBoundsRun) * step_m;
        sigma = 0.0;
      }
    } else {
      sigma = scene.bounds.most_per_m;
    }
  }
  if (above_m < kFar_m) reach_m = min(reach_m, length_rising(above_m, climb) + 0.02);
  if (below_m < kFar_m) reach_m = min(reach_m, length_sinking(below_m, climb) + 0.02);
  reach_m = max(reach_m, max(0.1, 2.0e-7 * f.s));  // s is a float: less would not move it
  return sigma;
}

// Optical depth to the next tentative collision. (Above 0: a logarithm that is but nearly exact may give less at 1.)
float optical_draw(inout Random random) { return max(-log(1.0 - random_unit(random)), 1.0e-9); }

// The density that second paths' directions are drawn from, over the cosine to the key light. Where light hardly turns it must be as
// narrow: a path of full weight that happens to run along the light would bring hundreds of times the mean.
bool guide_is_narrow() { return CLOUD.phase.g0 > kNarrow; }
float guide_density(float cosine) { return guide_is_narrow() ? phase_lobes(CLOUD.phase, cosine) : phase_hg(cosine, kGuideWidth); }
float guide_cosine(float u) { return guide_is_narrow() ? sample_lobes_cosine(CLOUD.phase, u) : sample_hg_cosine(kGuideWidth, u); }

// A path's weight after roulette. `cosine`: of its direction to the key light's.
vec3 gambled(vec3 weight, float cosine, inout Random random) {
  float size = max(abs(weight.x), max(abs(weight.y), abs(weight.z)));
  float least = kRouletteBelow / (1.0 + (guide_is_narrow() ? 4.0 * kPi : 2.0) * guide_density(cosine));
  if (size >= least) return weight;
  float survive = size / least;
  return random_unit(random) < survive ? weight / survive : vec3(0.0);
}

// Extinction at a place, all layers; the layer that has most of it.
float extinction_at(vec3 p, vec3 up, float height_m, out uint slot) {
  float sum = 0.0, most = 0.0;
  slot = 0u;
  CloudWeather w = cloud_weather_at(p, up, 0.0);
  for (uint l = 0u; l < LAYERS; ++l) {
    float sigma = 0.0;
    float eta = (height_m - cloud_base_m(l, w)) / CLOUD.layers[l].thickness_m;
    if (CLOUD.uniform_density > 0.0) {
      sigma = eta >= 0.0 && eta < 1.0 ? CLOUD.uniform_density * CLOUD.layers[l].extinction_per_m : 0.0;
    } else if (eta > 0.0 && eta < 1.0) {
      CloudColumn c = cloud_column(l, w, p, up, height_m, 0.0);
      sigma = cloud_medium_at(l, c, p, up, height_m, 0.0).mean_per_m;
    }
    sum += sigma;
    if (sigma > most) {
      most = sigma;
      slot = CLOUD.layers[l].slot;
    }
  }
  return sum;
}

vec3 key_illuminance_at(vec3 up, float height_m) {
  if (MODE == kTable) return vec3(1.0);
  float u = unit_from_key_mu(dot(up, frame.frame_data.key_dir));
  float v = (height_m - kKeyLow_m) / (kKeyHigh_m - kKeyLow_m);
  vec2 size = vec2(kKeyWidth, kKeyHeight);
  return textureLod(key_tex, (clamp(vec2(u, v), 0.0, 1.0) * (size - 1.0) + 0.5) / size, 0.0).rgb;
}

// The last pixel whose items begin at or before this one, by halving.
uint pixel_of(uint item) {
  uint low = 0u, high = push.pixels;
  while (high - low > 1u) {
    uint middle = (low + high) / 2u;
    if (plan.at[middle].first_item <= item) low = middle;
    else high = middle;
  }
  return low;
}

const uint kFetch = 0u, kMain = 1u, kShadow = 2u;

void main() {
  FrameConstants f = frame.frame_data;
  uint state = kFetch, item = 0u, pixel = 0u;
  Random random;
  Flight flight = flight_from(vec3(0.0), f.forward);
  PathResult result;
  vec3 weight = vec3(1.0), pending = vec3(0.0), next_dir = vec3(0.0), sunlit = vec3(0.0);
  float shadow = 1.0;
  ivec2 surface_pixel = ivec2(0);
  bool from_camera = true;
  // A second path in the light's direction: where the first one waits meanwhile.
  bool second = false, waiting = false;  // being followed; to be begun after the shadow
  vec3 wait_origin = vec3(0.0), wait_dir = vec3(0.0), wait_weight = vec3(0.0);
  float escaped = 0.0;  // sum of weights that escaped: one escape of a path's several is kept, chosen by weight
  uint paths = 0u, vertices = 0u, reads = 0u, moves = 0u, overruns = 0u;

  uint lane = gl_GlobalInvocationID.x, turns = 0u;
  if (TURNS > 0u) {
    PathLane saved = lanes.at[lane];
    state = saved.state;
    item = saved.item;
    pixel = saved.pixel;
    random = Random(saved.random_state, saved.random_increment);
    result = PathResult(vec3(0.0), saved.first_m, saved.escape_weight, saved.first_weight, saved.escape_height_m, saved.escape_up, saved.escape_dir,
                        saved.kind_and_flags & 255u);
    from_camera = (saved.kind_and_flags & 256u) != 0u;
    second = (saved.kind_and_flags & 512u) != 0u;
    waiting = (saved.kind_and_flags & 1024u) != 0u;
    wait_origin = saved.wait_origin;
    wait_dir = saved.wait_dir;
    wait_weight = saved.wait_weight;
    escaped = saved.escaped;
    surface_pixel = ivec2(saved.surface_xy & 0xffffu, saved.surface_xy >> 16u);
    if (state != kFetch) flight = flight_from(saved.origin, saved.dir);
    flight.s = saved.s;
    flight.end_m = saved.end_m;
    flight.left = saved.left;
    shadow = saved.shadow;
    weight = saved.weight;
    pending = saved.pending;
    next_dir = saved.next_dir;
    sunlit = saved.sunlit;
  }
  while (TURNS == 0u || turns < TURNS) {
    ++turns;
    bool begin = false;  // a flight from `start` along `way`
    vec3 start = vec3(0.0), way = vec3(0.0);
    if (state == kFetch) {
      item = atomicAdd(work.data.next, 1u);
      if (item >= push.items) break;  // the state stays: no path
      ++paths;
      pixel = pixel_of(item);
      random = random_stream(pixel, plan.at[pixel].first_sample + (item - plan.at[pixel].first_item), push.seed);
      result = PathResult(vec3(0.0), 0.0, vec3(0.0), 1.0, 0.0, 0u, 0u, kPathSky);
      weight = vec3(1.0);
      sunlit = vec3(0.0);
      second = waiting = false;
      escaped = 0.0;
      from_camera = MODE != kTable;
      state = kMain;
      vec2 u = vec2(random_unit(random), random_unit(random));
      float start_m = 0.0, end_m = kFar_m;
      if (MODE == kTable) {
        PathRay ray = rays.at[pixel];
        start = ray.origin;
        way = ray.spread > 0.0 ? sample_cosine_hemisphere(ray.dir, u) : ray.dir;
      } else {
        // Somewhere in the pixel; the surface is that of the nearest of its sub-pixels.
        vec2 at = (vec2(float(pixel % push.width), float(pixel / push.width)) + u) * float(push.subpixels);
        way = pixel_direction(f, at);
        surface_pixel = min(ivec2(at), ivec2(f.size) - 1);
        float top_m = scene.bounds.band_high_m[scene.bounds.bands - 1u] * 1.0034 + 1.0;
        vec2 hull;
        if (f.planet.camera_f_m2 > top_m * (2.0 * f.planet.a_m + top_m)) start_m = intersect_shell(f.planet, way, top_m, hull) ? max(hull.x, 0.0) : kFar_m;
        start = start_m < kFar_m ? way * start_m : vec3(0.0);
        float depth = texelFetch(surface_depth, surface_pixel, 0).r;
        if (MODE == kPicture && depth < 0.5 * kFarDepth_m) end_m = start_m < kFar_m ? depth - start_m : depth;
      }
      flight = flight_from(start, way);
      flight.s = start_m < kFar_m ? 0.0 : kFar_m;
      flight.end_m = MODE == kTable ? distance_to_ground_map(flight) : end_m;
      flight.left = optical_draw(random);
    }

    // Along the flight to the next tentative collision, or to its end.
    bool tentative = false;
    float majorant = 0.0;
    for (int k = 0; k < kMoves && !tentative && flight.s < flight.end_m; ++k) {
      float reach_m;
      majorant = bound_along(flight, reach_m);
      ++moves;
      float to_end = min(reach_m, flight.end_m - flight.s);
      if (majorant > 0.0 && majorant * to_end > flight.left) {
        flight.s += flight.left / majorant;
        tentative = true;
      } else {
        flight.left -= majorant * to_end;
        flight.s += reach_m;  // beyond the end where that is nearer
      }
    }

    bool vertex = false, done = false;  // of the path; of a shadow
    vec3 normal = vec3(0.0), albedo = vec3(0.0);
    float water = 0.0;
    bool in_cloud = false;
    if (tentative) {
      Place here = place_on(flight);
      vec3 p = flight.origin + flight.dir * flight.s;
      uint slot;
      float sigma = extinction_at(p, here.up, here.height_m, slot);
      ++reads;
      float share = sigma / majorant, u = random_unit(random);
      flight.left = optical_draw(random);
      if (sigma > 1.001 * majorant) ++overruns;
      if (state == kShadow) {
        shadow *= 1.0 - share;
        float size = abs(shadow);
        if (size < kShadowBelow) {
          float survive = max(size / kShadowBelow, 0.05);
          shadow = u < survive ? shadow / survive : 0.0;
        }
        done = shadow == 0.0;
      } else {
        // Where extinction exceeds its majorant, null collisions are negative (Galtier et al. 2013).
        float total = share + abs(1.0 - share);
        bool real = u * total < share;
        weight *= real || share <= 1.0 ? total : -total;
        if (real) {
          vertex = in_cloud = true;
          if (from_camera) {
            result.kind = kPathCloud + slot;
            result.first_m = length(p);
            result.first_weight = weight.x;
          }
        }
      }
    } else if (flight.s >= flight.end_m) {
      if (flight.end_m >= kFar_m) {
        // Gone to space.
        if (state == kMain) {
          flight.s = 0.0;
          Place here = place_on(flight);
          float size = max(abs(weight.x), max(abs(weight.y), abs(weight.z)));
          escaped += size;
          if (random_unit(random) * escaped < size) {
            result.weight = weight / max(size, 1.0e-30);
            result.escape_height_m = here.height_m;
            result.escape_up = pack_direction(here.up);
            result.escape_dir = pack_direction(flight.dir);
          }
          weight = vec3(0.0);
          done = true;
        } else {
          done = true;
        }
      } else if (state == kShadow) {
        shadow = 0.0;
        done = true;
      } else {
        vertex = true;
        if (from_camera) {
          result.kind = kPathSurface;
          result.first_m = length(flight.origin + flight.dir * flight.end_m);
          result.first_weight = weight.x;
        }
      }
    }

    if (vertex) {
      ++vertices;
      if (!in_cloud) flight.s = flight.end_m;
      Place here = place_on(flight);
      vec3 p = flight.origin + flight.dir * flight.s;
      vec3 key = frame.frame_data.key_dir;
      vec3 to_key = sample_cap(key, 1.0 - cos(f.sun_angular_radius_rad), vec2(random_unit(random), random_unit(random)));
      vec3 light = MODE == kFurnace ? vec3(0.0) : key_illuminance_at(here.up, here.height_m);
      vec2 u = vec2(random_unit(random), random_unit(random));
      float chance = random_unit(random), guide_share = 1.0;
      if (in_cloud) {
        weight *= CLOUD.single_scattering_albedo;
        float cosine = sample_lobes_cosine(CLOUD.phase, u.x);
        next_dir = direction_about(flight.dir, cosine, u.y);
        float guide = MODE == kFurnace ? 0.0 : second ? (guide_is_narrow() ? kGuideSecond : 0.0) : kGuide * smoothstep(0.2, 0.6, CLOUD.phase.g0);
        if (guide > 0.0) {
          // Two ways to the next direction, by the phase function and towards the light; weights by the balance heuristic.
          float p = phase_lobes(CLOUD.phase, cosine), density = guide_density(dot(next_dir, key));
          guide_share = p / (p + guide * density);
          if (chance < guide) {
            vec2 v = vec2(random_unit(random), random_unit(random));
            vec3 towards = direction_about(key, guide_cosine(v.x), v.y);
            float p2 = phase_lobes(CLOUD.phase, dot(flight.dir, towards)), density2 = guide_density(dot(towards, key));
            float share2 = p2 / (p2 + guide * density2);
            if (!second) {
              waiting = true;
              wait_dir = towards;
              wait_weight = weight * share2;
            } else {
              // No third path: one of the two goes on for both, by what they may bring; the drawn one at least half of the times, so
              // that its weight no more than doubles.
              float a = guide_share * (1.0 + kGuideValue * 4.0 * kPi * density), b = share2 * (1.0 + kGuideValue * 4.0 * kPi * density2);
              float share = min(b / (a + b), 0.5);
              bool turn = random_unit(random) < share;
              guide_share = turn ? share2 / share : guide_share / (1.0 - share);
              if (turn) next_dir = towards;
            }
          }
        }
        pending = weight * light * phase_lobes(CLOUD.phase, dot(flight.dir, to_key));
      } else {
        vec4 surface;
        normal = here.up;
        if (from_camera) {
          surface = texelFetch(surface_albedo, surface_pixel, 0);
          vec3 n = texelFetch(surface_normal, surface_pixel, 0).xyz;
          if (dot(n, n) > 0.25) normal = normalize(n);
          water = surface.a > 1.5 ? 1.0 : 0.0;
        } else {
          GroundPoint ground = ground_at(scene.ground, here.dir);
          surface = vec4(ground.albedo * push.ground_albedo_scale, 1.0);
          water = chance < ground.water ? 1.0 : 0.0;
          chance = ground.water > 0.0 && ground.water < 1.0 ? (water > 0.0 ? chance / ground.water : (chance - ground.water) / (1.0 - ground.water)) : chance;
        }
        if (water > 0.0) {
          float slopes = water_slope_variance(push.wind_mps);
          float cos_v = max(dot(here.up, -flight.dir), 1.0e-3);
          float fresnel = fresnel_rough(cos_v, 0.5 * slopes);
          vec3 body = water_body_albedo();
          float mu = max(dot(here.up, to_key), 0.0);
          pending = weight * light * (sun_glint_per_sr(here.up, -flight.dir, to_key, slopes) + (1.0 - fresnel) * body * (mu / kPi));
          // On with the mirrored ray or into the water, by their luminances' order.
          float mirror = clamp(fresnel, 0.5, 0.98);
          if (chance < mirror) {
            vec3 mirrored = reflect(flight.dir, sample_facet(here.up, 0.5 * slopes, u));
            float rise = dot(mirrored, here.up);
            next_dir = normalize(mirrored + here.up * max(0.0, 2.0 * -rise));  // a second facet turns it up again
            weight *= fresnel / mirror;
          } else {
            next_dir = sample_cosine_hemisphere(here.up, u);
            weight *= (1.0 - fresnel) * body / (1.0 - mirror);
          }
        } else {
          weight *= surface.rgb;
          pending = weight * light * (max(dot(normal, to_key), 0.0) / kPi);
          next_dir = sample_cosine_hemisphere(normal, u);
        }
      }
      // The less a vertex would send the seldomer its shadow is looked for.
      float sent = max(abs(pending.x), max(abs(pending.y), abs(pending.z))) / max(max(light.x, max(light.y, light.z)) * kShadowOf, 1.0e-30);
      if (sent < 1.0) pending = random_unit(random) < max(sent, kLeastShadows) ? pending / max(sent, kLeastShadows) : vec3(0.0);
      weight *= guide_share;
      // Roulette on what goes on: what heads for the light may weigh less, it will bring more.
      weight = gambled(weight, dot(next_dir, key), random);
      if (waiting) wait_weight = gambled(wait_weight, dot(wait_dir, key), random);
      from_camera = false;
      // Off the surface by a metre, so that rounding does not put the ground in the way.
      start = in_cloud ? p : p + here.up;
      shadow = 1.0;
      if (any(greaterThan(abs(pending), vec3(0.0)))) {
        begin = true;
        way = to_key;
        state = kShadow;
      } else {
        done = true;
      }
    } else {
      start = flight.origin;
    }

    if (done) {
      // The shadow is known: on with the path from the same vertex.
      sunlit += pending * shadow;  // nothing where none was sent
      pending = vec3(0.0);
      if (waiting) {
        // The second path first; the first one waits here.
        vec3 dir = wait_dir, w = wait_weight;
        wait_origin = start;
        wait_dir = next_dir;
        wait_weight = weight;
        next_dir = dir;
        weight = w;
        waiting = false;
        second = true;
      }
      if (second && all(equal(weight, vec3(0.0)))) {
        start = wait_origin;
        next_dir = wait_dir;
        weight = wait_weight;
        second = false;
      }
      if (all(equal(weight, vec3(0.0)))) {
        state = kFetch;
      } else {
        begin = true;
        way = next_dir;
        state = kMain;
      }
    }

    if (begin) {
      flight = flight_from(start, way);
      // The planet's own shadow is in the key light's table.
      if (MODE != kFurnace && state == kMain) flight.end_m = distance_to_ground_map(flight);
      flight.left = optical_draw(random);
    }
    if (state == kFetch) {
      result.sunlit = sunlit;
      result.weight *= escaped;
      results.at[item] = result;
    }
  }
  if (TURNS > 0u) {
    if (state != kFetch) atomicAdd(work.data.unfinished, 1u);
    lanes.at[lane] = PathLane(state, item, pixel, random.state, random.increment, result.kind | (from_camera ? 256u : 0u) | (second ? 512u : 0u) | (waiting ? 1024u : 0u),
                              uint(surface_pixel.x) | (uint(surface_pixel.y) << 16u), result.first_m, result.first_weight, flight.s,
                              flight.end_m, flight.left, shadow, flight.origin, flight.dir, weight, pending, next_dir, sunlit,
                              wait_origin, wait_dir, wait_weight, escaped, result.weight, result.escape_height_m, result.escape_up,
                              result.escape_dir);
  }
  atomicAdd(work.data.counts.paths, paths);
  atomicAdd(work.data.counts.vertices, vertices);
  atomicAdd(work.data.counts.density_reads, reads);
  atomicAdd(work.data.counts.moves, moves);
  atomicAdd(work.data.counts.overruns, overruns);
}
