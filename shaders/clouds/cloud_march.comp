#version 460
#extension GL_GOOGLE_include_directive : require
// Marches all cloud layers for every pixel. Writes what the clouds send to the eye as shares of the lights (cloud_shade.comp
// makes luminance of them) and their transmittance; and depth, optical depth, dominant layer and step count.
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_density.glsl"
#include "clouds/light_shared.h"
#include "clouds/octaves.h"
#include "clouds/powder.h"
#include "clouds/depth_split.h"
layout(constant_id = 5) const bool OCTAVES = false;  // multiple scattering by octave_sum() instead of traced light
layout(constant_id = 6) const bool CONE = false;     // looks at the sun within a cone
layout(constant_id = 8) const bool FINE = false;     // half as long steps
layout(constant_id = 9) const int RAYS = 1;          // through each pixel: 1 or 4
layout(set = 0, binding = 24) uniform sampler3D grid_tex;
layout(set = 0, binding = 28) uniform sampler3D most_tex;
layout(set = 0, binding = 25) uniform sampler3D cells_tex;  // of light_gather.comp
layout(set = 0, binding = 26) uniform sampler2D beam_tex;
layout(scalar, set = 0, binding = 27) uniform LightBlock { CloudLightConstants data; } light_data;
#include "clouds/cloud_grid.glsl"
#include "clouds/light_cells.glsl"
#include "clouds/cloud_light.glsl"
#include "clouds/cloud_search.glsl"
layout(set = 0, binding = 20, r32f) uniform readonly image2D depth_m;
layout(set = 0, binding = 21, rgba32f) uniform writeonly image2D out_light;
layout(set = 0, binding = 22, rgba32f) uniform writeonly image2D out_info;
layout(set = 0, binding = 23) uniform sampler2DArray cloud_blue;
#define TERRAIN_VOLUME_BINDING 31
#define TERRAIN_CONSTANT 7
#include "terrain/terrain_air.glsl"
#define PIXEL_LIST_BINDING 40
#define PIXEL_LIST_CONSTANT 10
#include "clouds/pixel_list.glsl"  // of an upscaled picture: the pixels of this frame
layout(set = 0, binding = 29, rgba32f) uniform writeonly image2D out_near;   // of the nearer of two depths: shares of the lights, opacity
layout(set = 0, binding = 30, rg32f) uniform writeonly image2D out_depths;   // the two, m; equal where one does (depth_split.h)

const float kStepShare = FINE ? 0.01 : 0.02;  // of the distance, of a step
const int kMaxSteps = FINE ? 512 : 256;
const int kSearchSteps = 12, kMarchSteps = 16;  // of one kind before the other has its turn
const int kModeSearch = 0, kModeAhead = 1, kModeMarch = 2;
const int kMaxLights = FINE ? 8 : 4;              // points of a ray that look for the sun
const float kLightShare = FINE ? 0.15 : 0.32;     // about how much of what the ray sees each stands for
const float kOneDepth = 0.02;       // of the depth: two that are closer than this are one
const float kOpaque = 1.0e-3;       // transmittance at which nothing behind matters
const float kDeepest = 8.0;         // optical depth at which the wide lobes are used up too
const float kColumn_m = 250.0;      // ground between two readings of the slow fields
const float kSkyView = 0.3;         // as CloudOctave.view, for light of the sky and the ground
const float kShapeStep = 0.13;      // with billows, a level of -1 is about so many sqrt(2500 m cell size) from a cloud
const float kRough = 0.0006;        // standard deviation of the level halfway between two samples, per metre, of cells of 2500 m

void main() {
  // Neighbouring lanes march in step: blocks of 4 x 2 pixels stay together better than rows of 8.
  uint lane = gl_LocalInvocationIndex;
  ivec2 pixel = ivec2(gl_WorkGroupID.xy * 8u + uvec2((lane & 3u) | ((lane >> 1) & 4u), ((lane >> 2) & 1u) | ((lane >> 3) & 6u)));
  if (LISTED) {
    if (!listed_pixel(gl_WorkGroupID.x * 64u + lane, pixel)) return;
  } else if (any(greaterThanEqual(pixel, ivec2(frame.frame_data.size)))) {
    return;
  }
  PlanetView planet = CLOUD_PLANET;
  vec3 sun = frame.frame_data.key_dir;

  vec2 span, gap;
  float entry_f_m2;
  float passed = 0.0, depth_sum = 0.0, weight_sum = 0.0, tau_sum = 0.0;  // sums over the rays
  vec4 layer_weight = vec4(0.0);
  vec3 light = vec3(0.0);  // share of sun illuminance, of sky illuminance, of ground exitance (1/sr)
  vec3 light_x = vec3(0.0);  // the same times split_place()
  vec4 split_sums = vec4(0.0);
  float first_m = 0.0;       // distance of the first cloud
  int all_steps = 0, samples = 0;  // samples: evaluations of a layer's density, for eye and sun
  int ray = 0;
  do {
  vec3 dir = pixel_direction(frame.frame_data, vec2(pixel) + (RAYS == 1 ? vec2(0.5) : 0.25 + 0.5 * vec2(ray & 1, ray >> 1)));
  float transmittance = 1.0, tau = 0.0;
  int steps = 0;
  if (hull_span(dir, imageLoad(depth_m, pixel).r, span, gap, entry_f_m2)) {
    float cos_sun = dot(dir, sun);
    float albedo = CLOUD.single_scattering_albedo;
    // Rows of the beam table for this ray's angle to the light.
    float beam_u = (sqrt(acos(clamp(cos_sun, -1.0, 1.0)) / kPi) * float(kBeamTexels - 1u) + 0.5) / float(kBeamTexels);
    vec4 beam0 = textureLod(beam_tex, vec2(beam_u, 0.25), 0.0), beam1 = textureLod(beam_tex, vec2(beam_u, 0.75), 0.0);
    float light_from = light_entry(planet, light_data.data.grid, dir);
    vec3 last_cell = vec3(0.0);
    vec2 waiting = vec2(0.0);
    bool any_cell = false;

    vec3 scaled_dir = scaled_from_cam(planet, dir);
    vec3 entry_q = planet.camera_q_m + scaled_dir * span.x;
    float f_slope = 2.0 * dot(entry_q, scaled_dir), f_bend = dot(scaled_dir, scaled_dir);
    float pixel_angle = frame.frame_data.pixel_angle_rad * (RAYS == 1 ? 1.0 : 0.5);
    float coarse = smoothstep(80.0, 500.0, pixel_angle * span.x);
    // Steps through a layer, at least; the shortest.
    float crossings = mix(24.0, 12.0, coarse), least_m = 2.0;
    if (CLOUD.uniform_density > 0.0) {
      crossings = max(160.0, 8.0 * CLOUD.uniform_density * CLOUD.layers[0].extinction_per_m * CLOUD.layers[0].thickness_m);
      least_m = 0.25;
    }
    float blue = texelFetch(cloud_blue, ivec3(pixel & 63, int(frame.frame_data.frame_index & 15u)), 0).r;
    if (RAYS > 1) blue = fract(blue + 0.25 * float(ray));
    blue = fract(blue + 0.618034 * float((frame.frame_data.seed + frame.frame_data.frame_index / 16u) & 1023u));
    float jitter = mix(mix(0.8, 1.0, blue), 0.9, coarse);  // of every step; from far away the field is smooth: no noise wanted
    float s = 0.0, end = span.y - span.x;         // along the ray from its entry: exact from any distance
    vec2 gap_s = gap - span.x;

    // Weather at distances that grow as squares: read here, where all rays of a group read together. (A software device pays
    // for everything within the march's loop at every step, whether a condition asks for it or not.)
    CloudWeather places[kPlaces];
    for (int i = 0; i < kPlaces; ++i) {
      float u = float(i) / float(kPlaces - 1);
      float place_t = span.x + end * u * u;
      vec3 place = dir * place_t;
      places[i] = cloud_weather_at(place, geodetic_up(planet, place), log2(max(pixel_angle * place_t, 1.0)));
    }

    // Slow fields of each layer in the stretch at hand: read at near_s and far_s, straight lines between.
    CloudColumn near[LAYERS], far[LAYERS];
    float near_s = 0.0, far_s = 0.0;
    for (uint l = 0u; l < LAYERS; ++l) near[l] = far[l] = CloudColumn(0.0, 0.0, 0.0, vec3(0.0), 0.0, 0.0, 0.0);
    vec4 sources[kMaxLights];
    CloudColumn columns[kMaxLights];
    uint source_layers[kMaxLights];
    vec4 pending = vec4(0.0);
    float pending_seen = 0.0, last_seen = 0.0;
    int lights = 0;
    float light_share = mix(kLightShare, FINE ? 0.2 : 0.45, coarse);
    float wide = 0.0;  // OCTAVES: optical depth so far as light of the sky knows it
    float cap = 1.0e9, shortest = 36.0;  // of the layer at hand: a share of the way through it, its shortest step
    float column_m = kColumn_m;
    uint main_layer = 0u;
    {
      vec3 entry_up = normalize(scaled_from_cam(planet, entry_q));
      for (uint l = 0u; l < LAYERS; ++l) {
        cap = min(cap, ray_over(CLOUD.layers[l].thickness_m, abs(dot(dir, entry_up))) / crossings);
        shortest = min(shortest, CLOUD.layers[l].step_m);
      }
    }
    CloudColumn lit = CloudColumn(0.0, 0.0, 0.0, vec3(0.0), 0.0, 0.0, 0.0);  // where light was last sent from
    // The march's sample before: a stretch of the ray is between two samples, its level on a straight line between theirs.
    float last_s = -1.0;  // below 0: there is none
    uint last_dense = 0u;
    vec4 last_level = vec4(0.0), last_eta = vec4(0.0);  // of each layer

    // Two loops take turns. One searches empty space by what is cheap to read and reads slow fields ahead; one marches through
    // what may be cloud. A software device runs the lanes of a group in step and pays for everything within a loop that any
    // lane is in: whole stretches of one kind cost a group less than steps that could be of either.
    uint dense = 0u;         // layers whose cloud may be here
    float safe_s = 0.0;      // up to here no other layer's can be
    int mode = kModeSearch;
    bool done = false;
    // (Conditions of loops are last: one at the head has such a device turn the loop once more than any lane needs.)
    if (s < end) do {
      float place = sqrt(clamp(s / end, 0.0, 1.0)) * float(kPlaces - 1);
      int first = min(int(place), kPlaces - 2);
      CloudWeather weather0 = places[first], weather1 = places[first + 1];
      float u0 = float(first) / float(kPlaces - 1), u1 = float(first + 1) / float(kPlaces - 1);
      float weather_s = end * u0 * u0, weather_per_m = 1.0 / (end * (u1 * u1 - u0 * u0)), weather_end = end * u1 * u1;

      int n = 0;
      if (mode != kModeMarch && (s < end || mode == kModeAhead)) do {
        ++steps;
        if (mode == kModeSearch && s >= gap_s.x && s < gap_s.y) {
          s = gap_s.y;
          last_s = -1.0;
        }
        float t = span.x + s;
        float fine = min(max(t * kStepShare, shortest), max(cap, least_m));
        float at_s = mode == kModeSearch ? s : far_s;
        float at = span.x + at_s;
        vec3 q = entry_q + scaled_dir * at_s;
        vec3 sq = vec3(q.xy, q.z * planet.a_over_b);
        float inv = inversesqrt(dot(sq, sq));
        vec3 up = sq * inv;
        float height_m = scaled_height_from_f(planet, entry_f_m2 + at_s * (f_slope + at_s * f_bend)) * length(q) * inv;
        vec3 p = dir * at;
        float rising = dot(dir, up), climb = abs(rising);
        CloudWeather here = mix_weather(weather0, weather1, clamp((at_s - weather_s) * weather_per_m, 0.0, 1.0));
        float log2_footprint = log2(max(pixel_angle * at, mode == kModeSearch ? 0.08 * fine : 1.0));

        // Which layers are here, and how far the others.
        uint todo = dense;
        bool in_layer = false;
        float step_m = 0.0;
        if (mode == kModeSearch) {
          float slope = GROUND || WEATHER != kWeatherUniform ? kBaseSlope : 1.0e-4;
          float leap_m = 1.0e9, next_cap = 1.0e9, next_shortest = 1.0e9;
          todo = 0u;
          for (uint l = 0u; l < LAYERS; ++l) {
            float base_m = cloud_base_m(l, here), thickness_m = CLOUD.layers[l].thickness_m;
            float away_m = max(base_m - height_m, height_m - base_m - thickness_m);
            float cross_m = max(ray_over(thickness_m, climb) / crossings, CLOUD.uniform_density > 0.0 ? 0.0 : min(CLOUD.layers[l].step_m, 0.1 * thickness_m));
            if (away_m < 0.0) {
              todo |= 1u << l;
              next_cap = min(next_cap, cross_m);
              next_shortest = min(next_shortest, CLOUD.layers[l].step_m);
            } else {
              float reach_m = ray_free(away_m, height_m < base_m, rising, slope);
              if (reach_m < leap_m) {
                leap_m = reach_m;
                if (todo == 0u) {
                  cap = cross_m;
                  shortest = CLOUD.layers[l].step_m;
                }
              }
            }
          }
          if (todo != 0u) {
            cap = next_cap;
            shortest = next_shortest;
          }
          leap_m = max(leap_m, 2.0);
          in_layer = todo != 0u;
          step_m = todo != 0u ? leap_m : max(leap_m, min(fine, 0.5 * cap));
          dense = 0u;
        }
        do {
          uint l = LAYERS > 1u && todo != 0u ? uint(findLSB(todo)) : 0u;
          CloudColumn c = cloud_column(l, here, p, up, height_m, log2_footprint);
          float eta = cloud_eta(l, c, height_m);
          float unknown = c.unknown;
          float level = cloud_cell_field(l, c, p, up, height_m, log2_footprint, unknown);
          float need = cloud_need(l, c, eta);
          level -= cell_threshold(need, c.probit);
          float reach = cloud_reach(l, level, need, eta, unknown);
          bool inside = todo != 0u && (CLOUD.uniform_density > 0.0 ? eta >= 0.0 && eta <= 1.0 : eta > 0.0 && eta < 1.0);
          if (CLOUD.uniform_density > 0.0) reach = 1.0;
          for (uint i = 0u; i < LAYERS; ++i) {
            if (i == l && mode == kModeSearch) near[i] = c;
            if (i == l && mode == kModeAhead) far[i] = c;
          }
          if (mode == kModeSearch && todo != 0u) {
            ++samples;
            float apart_m = kLevelStep * CLOUD.layers[l].cell_size_m;
            if (inside && reach > 0.0) dense |= 1u << l;
            else step_m = min(step_m, inside ? clamp(-reach * apart_m, fine, max(fine, min(fine + 0.08 * t + 0.5 * apart_m, 0.1 * crossings * cap))) : fine);
          }
          todo &= todo - 1u;
        } while (todo != 0u);
        if (mode == kModeAhead) {
          mode = kModeMarch;
        } else if (dense != 0u) {
          // Slow fields every few hundred metres of ground.
          mode = kModeAhead;
          near_s = at_s;
          column_m = max(max(kColumn_m, 2.0 * pixel_angle * at) / max(sqrt(max(1.0 - climb * climb, 0.0)), 0.05), 2.0 * fine);
          far_s = near_s + column_m;
          safe_s = s + min(step_m, 2.0e4);
        } else {
          s += (in_layer ? jitter : 1.0) * step_m;
          last_s = -1.0;
        }
      } while (++n < kSearchSteps && mode != kModeMarch && (s < end || mode == kModeAhead) && s < weather_end);

      n = 0;
      if (mode == kModeMarch) do {
        ++steps;
        float t = span.x + s;
        float fine = min(max(t * kStepShare, shortest), max(cap, least_m));
        float at_s = s, at = t;
        vec3 q = entry_q + scaled_dir * at_s;
        vec3 sq = vec3(q.xy, q.z * planet.a_over_b);
        float inv = inversesqrt(dot(sq, sq));
        vec3 up = sq * inv;
        float height_m = scaled_height_from_f(planet, entry_f_m2 + at_s * (f_slope + at_s * f_bend)) * length(q) * inv;
        vec3 p = dir * at;
        float footprint_m = max(pixel_angle * at, 0.08 * fine);
        float log2_footprint = log2(footprint_m);
        float between = (at_s - near_s) / max(far_s - near_s, 1.0e-3);
        float step_m = max(safe_s - s, 2.0);
        float sigma = 0.0, clump_depth = 0.0, eta_here = 0.0, sigma_best = 0.0;
        if (last_s < 0.0) last_s = s;
        float length_m = s - last_s;
        float enter = 0.0;  // share of the stretch that is before the cloud
        vec4 sigmas = vec4(0.0);
        CloudColumn column;
        bool out_of_it = true;
        uint todo = dense;
        do {
          uint l = LAYERS > 1u && todo != 0u ? uint(findLSB(todo)) : 0u;
          ++samples;
          CloudColumn c = mix_columns(near[0], far[0], between);
          for (uint i = 1u; i < LAYERS; ++i)
            if (i == l) c = mix_columns(near[i], far[i], between);
          float eta = cloud_eta(l, c, height_m);
          float unknown = c.unknown;
          float advance_m = fine;
          bool first = length_m <= 0.0 || (last_dense & (1u << l)) == 0u;
          float eta0 = first ? eta : last_eta[l], low = min(eta0, eta), high = max(eta0, eta);
          last_eta[l] = eta;
          if (CLOUD.uniform_density > 0.0) {
            float inside = high - low > 1.0e-6 ? max(min(high, 1.0) - max(low, 0.0), 0.0) / (high - low) : float(eta >= 0.0 && eta <= 1.0);
            float slab = inside * CLOUD.uniform_density * CLOUD.layers[l].extinction_per_m;
            sigma += slab;
            sigmas[CLOUD.layers[l].slot] = slab;
            column = c;
            if (eta >= 0.0 && eta <= 1.0) out_of_it = false;
          } else {
            float e = clamp(eta, 0.0, 1.0), size = sqrt(CLOUD.layers[l].cell_size_m / 2500.0);
            float level = cloud_cell_field(l, c, p, up, height_m, log2_footprint, unknown);
            float need = cloud_need(l, c, e);
            level -= cell_threshold(need, c.probit);
            bool between_faces = eta > 0.0 && eta < 1.0;
            float reach = between_faces ? cloud_reach(l, level, need, e, unknown) : -1.0;
            if (reach > 0.0) {
              out_of_it = false;
              CloudChurn churn = cloud_churn(l, p, up, e, log2_footprint);
              level += cloud_shape_level(l, c, churn, p, e, log2_footprint, unknown);
              if (level > -0.3 && level < 0.3 + CLOUD.layers[l].filter_width && transmittance > 0.1) level += cloud_detail_level(l, c, churn, p, e, log2_footprint, unknown);
              advance_m = clamp(-level * kShapeStep * 2500.0 * size, 0.6 * fine, 8.0 * fine);
            } else if (between_faces) {
              float apart_m = kLevelStep * CLOUD.layers[l].cell_size_m;
              advance_m = clamp(-reach * apart_m, fine, max(fine, min(fine + 0.08 * t + 0.5 * apart_m, 0.1 * crossings * cap)));
            }
            // The cut at the base is no slope: without it, and the part of the stretch below it counted off. (Far below 0 the
            // level says nothing about where between the samples it passes 0.)
            level = clamp(level + 40.0 * max(0.02 - e, 0.0), -0.6 - kShareReach * sqrt(unknown), 2.0);
            float level0 = first ? level : last_level[l], rise = level - level0, middle = 0.5 * (level0 + level);
            last_level[l] = level;
            low = max(low, 0.02 - clamp(level, 0.0, 0.8) / 40.0);
            float inside = abs(eta - eta0) > 1.0e-6 ? max(min(high, 1.0) - low, 0.0) / abs(eta - eta0) : float(eta >= low && eta < 1.0);
            // Gauss's two points of the stretch. What is between samples is rougher than a line.
            float blur = 0.15 * abs(rise) + min(kRough / size * length_m, 0.06) * (1.0 - coarse);
            float eta_mid = clamp(0.5 * (eta0 + eta), 0.0, 1.0);
            CloudMedium medium0 = cloud_medium(l, c.density, middle - 0.288675 * rise, unknown, blur, eta_mid, footprint_m);
            CloudMedium medium = cloud_medium(l, c.density, middle + 0.288675 * rise, unknown, blur, eta_mid, footprint_m);
            if (reach > 0.0 && level > 0.0)
              advance_m = tau < 4.0 ? clamp(1.0 / max(medium.sigma_per_m, 1.0e-4), 0.4 * fine, fine) : 3.0 * fine;  // about one optical depth
            float mean = 0.5 * inside * (medium0.sigma_per_m + medium.sigma_per_m);
            if (mean > sigma_best) {
              sigma_best = mean;
              column = c;
              main_layer = l;
              eta_here = eta_mid;
              clump_depth = max(medium0.clump_depth, medium.clump_depth);
              enter = level0 < 0.0 && level > 0.0 ? -level0 / rise : 0.0;
            }
            sigma += mean;
            sigmas[CLOUD.layers[l].slot] = mean;
          }
          step_m = min(step_m, advance_m);
          todo &= todo - 1u;
        } while (todo != 0u);
        last_s = s;
        last_dense = dense;
        bool at_end = s >= end, at_gap = s >= gap_s.x && s < gap_s.y;

        if (sigma > 0.0) {
          // The last stretch ends at the depth where the march does.
          float d_tau = min(sigma * length_m, kDeepest - tau + 1.0e-3);
          float inner_m = length_m * (1.0 - enter);
          // Where light fades towards the sun as fast as towards the eye, it is on the stretch's average what it is here.
          at = t - inner_m + inner_m * (d_tau > 0.01 ? -log(0.5 + 0.5 * exp(-d_tau)) / d_tau : 0.5);
          float w = transmittance * (1.0 - exp(-d_tau));
          if (weight_sum == 0.0) first_m = at;
          float x = split_place(at, first_m);
          split_sums += w * vec4(1.0, x, x * x, x * x * x);
          // Sunlight waits for its shadow; light that was scattered before is in the cells.
          pending += vec4(at * w, w * albedo, 0.0, 0.0);
          pending_seen += w;
          lit = column;
          if (pending_seen > light_share && lights < kMaxLights) {
            sources[lights] = vec4(pending.x / pending_seen, pending.yzw);
            last_seen = pending_seen;
            columns[lights] = column;
            source_layers[lights] = main_layer;
            ++lights;
            pending = vec4(0.0);
            pending_seen = 0.0;
          }
          if (OCTAVES) {
            // Inside a clump light of the sky and the ground fades slower than the view.
            float clump = max(clump_depth, 0.02);
            float d_wide = d_tau * (1.0 - exp(-kSkyView * clump)) / (1.0 - exp(-clump));
            float w_sky = exp(-wide) * (1.0 - exp(-d_wide)) * albedo;
            wide += d_wide;
            float h = clamp(eta_here, 0.0, 1.0);
            vec3 more = vec3(0.0, w_sky * mix(0.16, 0.55, h) / kPi, w_sky * mix(0.45, 0.1, h) / kPi);
            light += more;
            light_x += x * more;
          } else {
            float slice = light_slice(light_data.data.cells, at - light_from) / float(light_data.data.cells.slices);
            vec4 cell = textureLod(cells_tex, vec3((vec2(pixel) + 0.5) / vec2(frame.frame_data.size), slice), 0.0);
            // Where no light was traced that of the next place along the ray stands for it.
            if (cell.a > 0.02) {
              last_cell = cell.rgb / cell.a;
              light += waiting.x * last_cell;
              light_x += waiting.y * last_cell;
              waiting = vec2(0.0);
              any_cell = true;
            }
            vec2 more = w * albedo * vec2(1.0, x);
            if (any_cell) {
              light += more.x * last_cell;
              light_x += more.y * last_cell;
            } else {
              waiting += more;
            }
          }
          depth_sum += w * at;
          weight_sum += w;
          layer_weight += sigmas * (w / sigma);
          tau += d_tau;
          transmittance *= exp(-d_tau);
        }
        s = min(s + jitter * step_m, s < gap_s.x ? min(end, gap_s.x) : end);
        if (out_of_it || s >= safe_s || at_gap) mode = kModeSearch;
        else if (s + 0.5 * fine > far_s) {
          mode = kModeAhead;
          for (uint l = 0u; l < LAYERS; ++l) near[l] = far[l];
          near_s = far_s;
          far_s = max(far_s, s) + max(column_m, 2.0 * fine);
        }
        if (tau >= kDeepest || at_end) {
          s = end;
          done = true;
        }
      } while (!done && ++n < kMarchSteps && mode == kModeMarch);
    } while (steps < kMaxSteps && !done && (s < end || mode != kModeSearch));
    // What is left goes with the last source; or is the only one, where the ray sees little.
    if (pending_seen > 0.0) {
      if (lights == 0) {
        sources[0] = vec4(pending.x / pending_seen, pending.yzw);
        columns[0] = lit;
        source_layers[0] = main_layer;
        lights = 1;
      } else {
        sources[lights - 1] = vec4((sources[lights - 1].x * last_seen + pending.x) / (last_seen + pending_seen), sources[lights - 1].yzw + pending.yzw);
      }
    }
    // All lanes march towards the sun together here; within the loop above each step of one would have cost them all.
    samples += lights * (CONE ? kConeTaps : kSunTaps);
    int i = 0;
    if (lights > 0) do {
      float at = sources[i].x;
      float at_s = at - span.x;
      vec3 q = entry_q + scaled_dir * at_s;
      vec3 sq = vec3(q.xy, q.z * planet.a_over_b);
      float inv = inversesqrt(dot(sq, sq));
      float height_m = scaled_height_from_f(planet, entry_f_m2 + at_s * (f_slope + at_s * f_bend)) * length(q) * inv;
      float footprint_m = max(pixel_angle * at, 0.08 * max(at * 0.013, 27.0));
      float sun_depth;
      if (OCTAVES) sun_depth = octave_sun_depth(source_layers[i], columns[i], dir * at, sq * inv, height_m, log2(footprint_m));
      else if (FINE) sun_depth = cloud_sun_depth(source_layers[i], columns[i], dir * at, sq * inv, height_m, log2(footprint_m));
      else sun_depth = quick_sun_depth(source_layers[i], columns[i], dir * at, sq * inv, height_m, log2(footprint_m));
      float sent, powder = powder_factor(sun_depth, cos_sun, CLOUD.powder);
      if (OCTAVES) sent = sources[i].y * octave_sum(cos_sun, CLOUD.phase, CLOUD.multiple_scattering_weight, sun_depth);
      else sent = sources[i].y * beam_sum(beam0, beam1, light_data.data.forward_albedo, sun_depth);
      sent *= powder * terrain_air_share(dir * at);
      light.x += sent;
      light_x.x += sent * split_place(at, first_m);
    } while (++i < lights);
    if (transmittance < kOpaque) transmittance = 0.0;
  }
  passed += transmittance;
  tau_sum += tau;
  all_steps += steps;
  } while (++ray < RAYS);
  float transmittance = passed / float(RAYS);
  light /= float(RAYS);
  light_x /= float(RAYS);

  float mean_m = weight_sum > 0.0 ? depth_sum / weight_sum : kFarDepth_m;
  float dominant = 0.0, most = 0.0;
  for (int i = 0; i < 4; ++i)
    if (layer_weight[i] > most) {
      most = layer_weight[i];
      dominant = float(i + 1);
    }
  // Two depths for the air before it, where one would be wrong.
  vec4 near = vec4(0.0);
  vec2 depths = vec2(mean_m);
  if (weight_sum > 0.0) {
    DepthSplit split = split_depths(split_sums);
    vec2 at = vec2(split_distance(split.near_x, first_m), split_distance(split.far_x, first_m));
    if (at.y - at.x > kOneDepth * mean_m) {
      depths = at;
      near = vec4(split_near_part(split, light.x, light_x.x), split_near_part(split, light.y, light_x.y),
                  split_near_part(split, light.z, light_x.z), split.near_share * (1.0 - transmittance));
    }
  }
  imageStore(out_light, pixel, vec4(light, transmittance));
  imageStore(out_near, pixel, near);
  imageStore(out_depths, pixel, vec4(depths, 0.0, 0.0));
  imageStore(out_info, pixel, vec4(mean_m, tau_sum / float(RAYS), dominant, float(all_steps) + 1024.0 * float(samples)));
}
