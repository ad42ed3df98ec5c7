// The one density of the clouds: the view march, light, shadows, probes, calibration and the path tracer all include this file.
//
// A point is inside a layer's cloud where a level L > 0: the sum of fields of unit variance on the sphere (regional, meso,
// cells), plus the probit of the local coverage, minus what the height asks for, plus billows. Each field fades to its mean
// where the footprint outgrows it, and the variance it leaves behind widens the step from 0 to 1, so that mean cover and
// mean density stay (docs/clouds.md).
//
// Needs `frame` (FrameConstants in frame.frame_data) declared before, or CLOUD_PLANET and CLOUD_ANCHOR defined (probes);
// CLOUD_BINDING is the first of eleven bindings.
#ifndef NEPHO_CLOUD_DENSITY_GLSL
#define NEPHO_CLOUD_DENSITY_GLSL
#include "clouds/clouds_shared.h"
#include "common/frame.h"

layout(constant_id = 1) const uint LAYERS = 4u;        // drawn layers
layout(constant_id = 2) const uint PHASES = 2u;        // 2 only around a window's ends, see CloudAnchor
layout(constant_id = 3) const uint WEATHER = 1u;       // kWeather...
layout(constant_id = 4) const bool GROUND = true;      // some base follows the ground or the geoid
const uint kWeatherUniform = 0u, kWeatherMap = 1u, kWeatherTile = 2u;

#ifndef CLOUD_BINDING
#define CLOUD_BINDING 1
#endif
layout(scalar, set = 0, binding = CLOUD_BINDING) uniform CloudBlock { CloudConstants cloud_data; } cloud;
layout(set = 0, binding = CLOUD_BINDING + 1) uniform samplerCube cloud_weather;
layout(set = 0, binding = CLOUD_BINDING + 2) uniform samplerCube cloud_properties;
layout(set = 0, binding = CLOUD_BINDING + 3) uniform samplerCube cloud_ground;
layout(set = 0, binding = CLOUD_BINDING + 4) uniform sampler2D cloud_tile;
layout(set = 0, binding = CLOUD_BINDING + 5) uniform sampler3D cloud_field;
layout(set = 0, binding = CLOUD_BINDING + 6) uniform sampler3D cloud_cells;
layout(set = 0, binding = CLOUD_BINDING + 7) uniform sampler3D cloud_shape;
layout(set = 0, binding = CLOUD_BINDING + 8) uniform sampler3D cloud_detail;
layout(set = 0, binding = CLOUD_BINDING + 9) uniform sampler3D cloud_turbulence;

#define CLOUD cloud.cloud_data
#ifndef CLOUD_ANCHOR
#define CLOUD_ANCHOR cloud.cloud_data.anchor
#define CLOUD_PLANET frame.frame_data.planet
#endif

const float kShapeWeight = 0.34;      // standard deviations
const float kDetailWeight = 0.11;
const float kFineWeight = 0.045;
const float kEdge = 0.02;             // softness of a resolved edge
// A mip with texels T, filtered linearly, averages like a box of sqrt(3) T: which mip is a footprint's.
const float kFilterBias = -0.79;
const float kNoiseRange = 4.0;        // textures hold -range..range standard deviations
const float kMesoBend_m = 3.5e3;      // per standard deviation: how far one field bends the lattice of the next
const float kCellSlant = 0.3;        // height that cells change their form over, against their size on the ground
const float kPoleCalm = 0.0025;       // winds fade within some 300 km of the poles, where east has no direction

vec3 cloud_uvw(uint domain, uint phase, vec3 p_cam) {
  return CLOUD_ANCHOR.offsets[domain * kCloudPhases + phase] + CLOUD.domains[domain].uvw_from_ecef * p_cam;
}

// East (short near the poles) and north at a point, from its geodetic normal; ECEF axes.
vec3 cloud_east(vec3 up) { return vec3(-up.y, up.x, 0.0) * inversesqrt(dot(up.xy, up.xy) + kPoleCalm); }

vec3 cloud_velocity(uint l, vec3 up) {
  vec3 east = cloud_east(up);
  vec2 wind = CLOUD.layers[l].wind_mps;
  return east * wind.x + cross(up, east) * wind.y + up * CLOUD.layers[l].evolution_mps;
}

// Noise is read at whole mips: lavapipe and old GPUs pay double for blending two, and the fades hide the change.
vec4 cloud_read_field(uint domain, vec3 p_cam, vec3 velocity, float lod) {
  vec4 sum = vec4(0.0);
  for (uint k = 0u; k < PHASES; ++k)
    sum += CLOUD_ANCHOR.weight[k] * (textureLod(cloud_field, cloud_uvw(domain, k, p_cam - velocity * CLOUD_ANCHOR.age_s[k]), round(lod)) - 0.5);
  return sum * (2.0 * kNoiseRange);
}

// What the weather map has over a point.
struct CloudWeather {
  vec4 coverage;    // channels, as the map has them
  vec4 properties;  // type, base offset in m, density factor, precipitation
  vec2 ground_m;    // geoid and smoothed ground above the ellipsoid
};

CloudWeather cloud_weather_at(vec3 p_cam, vec3 up, float log2_footprint) {
  CloudWeather w = CloudWeather(vec4(CLOUD.uniform_coverage), vec4(0.5, 0.0, 1.0, 0.0), vec2(0.0));
  if (WEATHER == kWeatherMap) {
    vec3 q = CLOUD_ANCHOR.weather_from_ecef * planet_q(CLOUD_PLANET, p_cam);
    float lod = max(log2_footprint - CLOUD.log2_weather_texel_m, 0.0);
    w.coverage = textureLod(cloud_weather, q, lod);
    w.properties = textureLod(cloud_properties, q, lod);
  }
  if (WEATHER == kWeatherTile) {
    // Three planes, blended by the normal so narrowly that most places see one; variance kept (Heitz and Neyret 2018).
    vec3 uvw = cloud_uvw(kDomainTile, 0u, p_cam);
    vec3 a = up * up;
    a *= a;
    a *= a;
    a /= a.x + a.y + a.z;
    float lod = max(log2_footprint - CLOUD.domains[kDomainTile].log2_texel_m, 0.0);
    vec4 mean = textureLod(cloud_tile, vec2(0.5), 16.0);
    vec4 v = a.x * (textureLod(cloud_tile, uvw.yz, lod) - mean) + a.y * (textureLod(cloud_tile, uvw.zx, lod) - mean) +
             a.z * (textureLod(cloud_tile, uvw.xy, lod) - mean);
    w.coverage = clamp(mean + v * inversesqrt(dot(a, a)), 0.0, 1.0);
  }
  if (GROUND) w.ground_m = textureLod(cloud_ground, planet_q(CLOUD_PLANET, p_cam), max(log2_footprint - 15.6, 0.0)).rg;
  return w;
}

float cloud_base_m(uint l, CloudWeather w) {
  return CLOUD.layers[l].base_m + w.properties.y + CLOUD.layers[l].geoid_weight * w.ground_m.x + CLOUD.layers[l].ground_weight * w.ground_m.y;
}

// Probit of a layer's local coverage, through its calibrated thresholds.
float cloud_probit(uint l, CloudWeather w) {
  float value = clamp(dot(CLOUD.layers[l].channel, w.coverage), 0.0, 1.0);
  if (WEATHER != kWeatherUniform) value = exp2(CLOUD.layers[l].weather_exponent * log2(max(value, 1.0e-6)));
  float z = probit_from_share(min(value * CLOUD.layers[l].coverage_scale, 1.0));
  float at = clamp((z - kThresholdFirst) / kThresholdStep, 0.0, 15.0);
  int i = min(int(at), 14);
  float inside = mix(CLOUD.layers[l].thresholds[i], CLOUD.layers[l].thresholds[i + 1], at - float(i));
  return inside + (z - (kThresholdFirst + at * kThresholdStep));
}

// What does not change with height or within some hundred metres.
struct CloudColumn {
  float probit;    // of the local coverage, calibrated
  float slow;      // regional + meso level
  float unknown;   // variance of what the footprint hides of them
  vec3 bend;       // displacement of the smaller lattices, m
  float base_m;    // geodetic height of the layer's base
  float relief;    // top_relief here
  float density;   // factor of the extinction
};

CloudColumn cloud_column(uint l, CloudWeather w, vec3 p_cam, vec3 up, float height_m, float log2_footprint) {
  CloudColumn c;
  c.probit = cloud_probit(l, w);
  c.base_m = cloud_base_m(l, w);
  c.relief = CLOUD.layers[l].top_relief * exp2(2.0 * (w.properties.x - 0.5));
  c.density = w.properties.z * (1.0 + 0.6 * w.properties.w);  // rain makes it denser
  vec3 foot = p_cam - up * height_m;  // columns are vertical: the field is read on the ellipsoid
  vec3 velocity = cloud_velocity(l, up);
  uint first = kDomainOfLayer + l * kLayerDomains;
  float regional_lod = max(log2_footprint + kFilterBias - CLOUD.domains[first + kRegional].log2_texel_m, 0.0);
  float meso_lod = max(log2_footprint + kFilterBias - CLOUD.domains[first + kMeso].log2_texel_m, 0.0);
  // One field bends the lattice of the next.
  vec4 regional = cloud_read_field(first + kRegional, foot, velocity, regional_lod);
  vec4 meso = cloud_read_field(first + kMeso, foot + kMesoBend_m * regional.yzw, velocity, meso_lod);
  float wr = CLOUD.layers[l].regional_weight, wm = CLOUD.layers[l].meso_weight;
  c.slow = wr * regional.x + wm * meso.x;
  c.unknown = wr * wr * (1.0 - variance_left(regional_lod, CLOUD.fades.field.x, CLOUD.fades.field.y)) +
              wm * wm * (1.0 - variance_left(meso_lod, CLOUD.fades.field.x, CLOUD.fades.field.y));
  c.bend = CLOUD.layers[l].bend_m.x * regional.yzw + CLOUD.layers[l].bend_m.y * meso.yzw;
  return c;
}

CloudColumn mix_columns(CloudColumn a, CloudColumn b, float u) {
  return CloudColumn(mix(a.probit, b.probit, u), mix(a.slow, b.slow, u), mix(a.unknown, b.unknown, u), mix(a.bend, b.bend, u),
                     mix(a.base_m, b.base_m, u), mix(a.relief, b.relief, u), mix(a.density, b.density, u));
}

float cloud_eta(uint l, CloudColumn c, float height_m) { return (height_m - c.base_m) / CLOUD.layers[l].thickness_m; }

// Level of the column's cells at a relative height, without the local coverage, and without billows; `unknown` gains the
// variance the footprint hides. cloud_level_at() makes the level of it.
float cloud_cell_field(uint l, CloudColumn c, vec3 p_cam, vec3 up, float height_m, float log2_footprint, inout float unknown) {
  uint domain = kDomainOfLayer + l * kLayerDomains + kCell;
  float lod = max(log2_footprint + kFilterBias - CLOUD.domains[domain].log2_texel_m, 0.0);
  float roundness = CLOUD.layers[l].cell_roundness, weight = CLOUD.layers[l].cell_weight;
  vec2 parts = vec2(roundness, 1.0 - roundness) * inversesqrt(roundness * roundness + (1.0 - roundness) * (1.0 - roundness));
  vec2 left = vec2(variance_left(lod, CLOUD.fades.cells_round.x, CLOUD.fades.cells_round.y),
                   variance_left(lod, CLOUD.fades.cells_fractal.x, CLOUD.fades.cells_fractal.y));
  unknown += weight * weight * (1.0 - dot(parts * parts, left));
  vec3 east = cloud_east(up);
  float rise_m = height_m - c.base_m;
  vec3 leaning = (east * CLOUD.layers[l].lean.x + cross(up, east) * CLOUD.layers[l].lean.y) * rise_m;
  vec3 foot = p_cam - up * (height_m - kCellSlant * rise_m) - leaning + c.bend;
  vec2 wind = CLOUD.layers[l].wind_mps;
  vec3 velocity = east * wind.x + cross(up, east) * wind.y + up * CLOUD.layers[l].evolution_mps;
  float cell = 0.0;
  for (uint k = 0u; k < PHASES; ++k)
    cell += CLOUD_ANCHOR.weight[k] * dot(parts, textureLod(cloud_cells, cloud_uvw(domain, k, foot - velocity * CLOUD_ANCHOR.age_s[k]), round(lod)).rg - 0.5);
  return c.slow + weight * cell * (2.0 * kNoiseRange);
}

float cloud_need(uint l, CloudColumn c, float eta) {
  return excess_needed(eta, CLOUD.layers[l].altering_bias, c.relief, CLOUD.layers[l].anvil_amount);
}

float cloud_cell_level(uint l, CloudColumn c, vec3 p_cam, vec3 up, float height_m, float eta, float log2_footprint, inout float unknown) {
  return cloud_cell_field(l, c, p_cam, up, height_m, log2_footprint, unknown) - cell_threshold(cloud_need(l, c, eta), c.probit);
}

// How far small noises move with their layer and their own velocity, and how turbulence churns them: most at the base.
struct CloudChurn {
  vec3 velocity_shape, velocity_detail, turbulence;
};

CloudChurn cloud_churn(uint l, vec3 p_cam, vec3 up, float eta, float log2_footprint) {
  vec3 east = cloud_east(up), north = cross(up, east);
  vec2 wind = CLOUD.layers[l].wind_mps;
  vec3 own = east * wind.x + north * wind.y + up * CLOUD.layers[l].evolution_mps;
  CloudChurn churn;
  churn.velocity_shape = own + east * CLOUD.shape_velocity_mps.x + north * CLOUD.shape_velocity_mps.y + up * CLOUD.shape_velocity_mps.z;
  churn.velocity_detail = own + east * CLOUD.detail_velocity_mps.x + north * CLOUD.detail_velocity_mps.y + up * CLOUD.detail_velocity_mps.z;
  float lod = max(log2_footprint - CLOUD.domains[kDomainTurbulence].log2_texel_m, 0.0);
  churn.turbulence = vec3(0.0);
  for (uint k = 0u; k < PHASES; ++k)
    churn.turbulence += CLOUD_ANCHOR.weight[k] * (textureLod(cloud_turbulence, cloud_uvw(kDomainTurbulence, k, p_cam - own * CLOUD_ANCHOR.age_s[k]), round(lod)).xyz - 0.5);
  churn.turbulence *= 2.0 * kNoiseRange;
  churn.turbulence *= mix(1.0, 0.4, smoothstep(0.0, 0.35, eta));
  return churn;
}

// Billows above, wisps below. Large scale.
float cloud_shape_level(uint l, CloudColumn c, CloudChurn churn, vec3 p_cam, float eta, float log2_footprint, inout float unknown) {
  uint domain = kDomainOfLayer + l * kLayerDomains + kShape;
  float lod = max(log2_footprint + kFilterBias - CLOUD.domains[domain].log2_texel_m, 0.0);
  float weight = kShapeWeight * CLOUD.layers[l].shape_amount * smoothstep(0.0, 0.25, eta) * (1.0 - 0.75 * anvil_share(eta, CLOUD.layers[l].anvil_amount));
  unknown += weight * weight * (1.0 - variance_left(lod, CLOUD.fades.shape.x, CLOUD.fades.shape.y));
  vec3 p = p_cam + c.bend + CLOUD.shape_displacement_m * churn.turbulence;
  float shape = 0.0;
  for (uint k = 0u; k < PHASES; ++k)
    shape += CLOUD_ANCHOR.weight[k] * (textureLod(cloud_shape, cloud_uvw(domain, k, p - churn.velocity_shape * CLOUD_ANCHOR.age_s[k]), round(lod)).r - 0.5);
  return lod > 5.5 ? 0.0 : weight * shape * (2.0 * kNoiseRange);
}

float cloud_detail_level(uint l, CloudColumn c, CloudChurn churn, vec3 p_cam, float eta, float log2_footprint, inout float unknown) {
  uint domain = kDomainOfLayer + l * kLayerDomains + kDetail;
  float lod = max(log2_footprint + kFilterBias - CLOUD.domains[domain].log2_texel_m, 0.0);
  float weight = kDetailWeight * CLOUD.layers[l].detail_amount * mix(-1.0, 1.0, smoothstep(0.05, 0.3, eta));
  unknown += weight * weight * (1.0 - variance_left(lod, CLOUD.fades.detail.x, CLOUD.fades.detail.y));
  vec3 p = p_cam + 0.5 * c.bend;
  vec3 at = p + CLOUD.detail_displacement_m * churn.turbulence;
  float detail = 0.0;
  for (uint k = 0u; k < PHASES; ++k)
    detail += CLOUD_ANCHOR.weight[k] * (textureLod(cloud_detail, cloud_uvw(domain, k, at - churn.velocity_detail * CLOUD_ANCHOR.age_s[k]), round(lod)).r - 0.5);
  float level = lod > 4.5 ? 0.0 : weight * detail * (2.0 * kNoiseRange);
  lod = log2_footprint - CLOUD.domains[domain + 1u].log2_texel_m;
  at = p + CLOUD.fine_displacement_m * churn.turbulence;
  float fine = 0.0;
  for (uint k = 0u; k < PHASES; ++k)
    fine += CLOUD_ANCHOR.weight[k] * (textureLod(cloud_detail, cloud_uvw(domain + 1u, k, at - churn.velocity_detail * CLOUD_ANCHOR.age_s[k]), max(lod, 0.0)).r - 0.5);
  return level + kFineWeight * CLOUD.layers[l].detail_amount * fine * (2.0 * kNoiseRange) * smoothstep(2.5, 1.0, lod);
}

// Everything: the level's field without coverage and height (calibration sweeps those).
float cloud_full_field(uint l, CloudColumn c, vec3 p_cam, vec3 up, float height_m, float eta, float log2_footprint, inout float unknown) {
  float field = cloud_cell_field(l, c, p_cam, up, height_m, log2_footprint, unknown);
  CloudChurn churn = cloud_churn(l, p_cam, up, eta, log2_footprint);
  field += cloud_shape_level(l, c, churn, p_cam, eta, log2_footprint, unknown);
  return field + cloud_detail_level(l, c, churn, p_cam, eta, log2_footprint, unknown);
}

// Extinction from the level.
struct CloudMedium {
  float mean_per_m;   // extinction, mean over the footprint
  float sigma_per_m;  // what a ray sees: of clumps where they are unresolved
  float clump_depth;  // optical depth of one clump; towards 0 where everything is resolved
};

CloudMedium cloud_medium(uint l, float density, float level, float unknown, float blur, float eta, float footprint_m) {
  float spread = sqrt(unknown + kEdge * kEdge + blur * blur);
  float share = share_above(level, spread);
  float sigma = CLOUD.layers[l].extinction_per_m * density * density_profile(CLOUD.layers[l].profile, eta);
  CloudMedium m = CloudMedium(0.0, 0.0, 0.0);
  m.mean_per_m = sigma * mean_ramp(level, CLOUD.layers[l].filter_width, spread);
  float size_m = clamp(0.5 * footprint_m, 1.0, 0.5 * CLOUD.layers[l].thickness_m);
  if (share > 1.0e-5) {
    float inside = m.mean_per_m / share;
    m.sigma_per_m = clumped_extinction(share, inside, size_m);
    m.clump_depth = inside * size_m;
  }
  return m;
}

// The whole density at a point: mean extinction of layer l, 1/m.
CloudMedium cloud_medium_at(uint l, CloudColumn c, vec3 p_cam, vec3 up, float height_m, float log2_footprint) {
  float eta = cloud_eta(l, c, height_m);
  if (eta <= 0.0 || eta >= 1.0) return CloudMedium(0.0, 0.0, 0.0);
  float unknown = c.unknown;
  float field = cloud_full_field(l, c, p_cam, up, height_m, eta, log2_footprint, unknown);
  return cloud_medium(l, c.density, field - cell_threshold(cloud_need(l, c, eta), c.probit), unknown, 0.0, eta, exp2(log2_footprint));
}

#endif
