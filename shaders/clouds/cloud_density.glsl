// The one density of the clouds: the view march, light, shadows, probes and the path tracer all include this file.
// Needs `frame` (FrameConstants in frame.frame_data) declared before; CLOUD_BINDING is the first of five bindings.
//
// A point is inside a cloud where a level L > 0: the sum of fields of unit variance on the sphere (coverage, regional,
// meso, cells), minus what the height asks for, plus billows. Each field fades to its mean where the footprint outgrows
// it, and the variance it leaves behind widens the step from 0 to 1, so that mean cover stays (docs/clouds.md).
#ifndef NEPHO_CLOUD_DENSITY_GLSL
#define NEPHO_CLOUD_DENSITY_GLSL
#include "clouds/clouds_shared.h"
#include "common/frame.h"

#ifndef CLOUD_BINDING
#define CLOUD_BINDING 1
#endif
layout(scalar, set = 0, binding = CLOUD_BINDING) uniform CloudBlock { CloudConstants cloud_data; } cloud;
layout(set = 0, binding = CLOUD_BINDING + 1) uniform samplerCube cloud_weather;
layout(set = 0, binding = CLOUD_BINDING + 2) uniform sampler3D cloud_field;
layout(set = 0, binding = CLOUD_BINDING + 3) uniform sampler3D cloud_shape;
layout(set = 0, binding = CLOUD_BINDING + 4) uniform sampler3D cloud_detail;

#define CLOUD cloud.cloud_data

const float kRegionalWeight = 0.45;  // standard deviations; their squares add to 1
const float kMesoWeight = 0.55;
const float kCellWeight = 0.704;
const float kShapeWeight = 0.34;
const float kDetailWeight = 0.11;
const float kFineWeight = 0.04;
const float kEdge = 0.02;            // softness of a resolved edge
const float kFieldBias = 0.7;         // fields fade a little before a pixel reaches their texel: no twinkle from orbit
const float kRegionalBias = 1.8;      // the weather map alone is seen from far out
const float kNoiseRange = 4.0;       // textures hold -range..range standard deviations

// Noise is read at whole mips: lavapipe and old GPUs pay double for blending two, and the fades hide the change.
vec3 cloud_uvw(uint domain, vec3 p_cam) { return CLOUD.domains[domain].offset + CLOUD.domains[domain].uvw_from_cam * p_cam; }


// What does not change with height or within some hundred metres.
struct CloudColumn {
  float probit;    // of the local coverage, through threshold_probit()
  float slow;      // regional + meso level
  float unknown;   // variance of what the footprint hides of them
  vec2 bend;       // displacement of the cells, in their texture coordinate
};

// Probit of the coverage that the weather map (20 km texels) has over a point.
float cloud_probit(vec3 p_cam, float log2_footprint) {
  vec3 q = planet_q(frame.frame_data.planet, p_cam);
  float share = textureLod(cloud_weather, CLOUD.weather_from_ecef * q, max(log2_footprint - CLOUD.log2_weather_texel_m, 0.0)).r;
  return threshold_probit(probit_from_share(share));
}

CloudColumn cloud_column_with(float probit, vec3 p_cam, vec3 up, float height_m, float log2_footprint) {
  CloudColumn c;
  c.probit = probit;
  vec3 foot = p_cam - up * height_m;  // columns are vertical: the field is read on the ellipsoid
  float lod = max(log2_footprint + kRegionalBias - CLOUD.domains[kDomainRegional].log2_texel_m, 0.0);
  // One field bends the lattice of the next.
  vec3 uvw = cloud_uvw(kDomainRegional, foot);
  uvw.yz += (textureLod(cloud_field, cloud_uvw(kDomainWarp, foot), 0.0).rg - 0.5) * (2.0 * kNoiseRange * 0.12);
  vec2 regional = (textureLod(cloud_field, uvw, round(lod)).rg - 0.5) * (2.0 * kNoiseRange);
  float left = variance_left(lod, CLOUD.fade_start.x, CLOUD.fade_per_lod.x);
  lod = max(log2_footprint + kFieldBias - CLOUD.domains[kDomainMeso].log2_texel_m, 0.0);
  uvw = cloud_uvw(kDomainMeso, foot);
  uvw.xy += 0.09 * regional;
  vec2 meso = (textureLod(cloud_field, uvw, round(lod)).rg - 0.5) * (2.0 * kNoiseRange);
  c.slow = kRegionalWeight * regional.x + kMesoWeight * meso.x;
  c.unknown = kRegionalWeight * kRegionalWeight * (1.0 - left) + 
              kMesoWeight * kMesoWeight * (1.0 - variance_left(lod, CLOUD.fade_start.x, CLOUD.fade_per_lod.x));
  c.bend = 0.03 * meso;
  return c;
}

CloudColumn cloud_column(vec3 p_cam, vec3 up, float height_m, float log2_footprint) {
  return cloud_column_with(cloud_probit(p_cam, log2_footprint), p_cam, up, height_m, log2_footprint);
}

CloudColumn mix_columns(CloudColumn a, CloudColumn b, float u) {
  return CloudColumn(mix(a.probit, b.probit, u), mix(a.slow, b.slow, u), mix(a.unknown, b.unknown, u), mix(a.bend, b.bend, u));
}

// Level of the column's cells at a relative height, without billows; `unknown` gains the variance the footprint hides.
float cloud_cell_level(CloudColumn c, vec3 p_cam, vec3 up, float height_m, float eta, float log2_footprint, inout float unknown) {
  float lod = max(log2_footprint + kFieldBias - CLOUD.domains[kDomainCell].log2_texel_m, 0.0);
  vec3 uvw = cloud_uvw(kDomainCell, p_cam - up * height_m);
  uvw.yz += c.bend;
  float cell = lod > 5.5 ? 0.0 : (textureLod(cloud_field, uvw, round(lod)).g - 0.5) * (2.0 * kNoiseRange);
  unknown += kCellWeight * kCellWeight * (1.0 - variance_left(lod, CLOUD.fade_start.y, CLOUD.fade_per_lod.y));
  return c.slow + kCellWeight * cell - cell_threshold(eta, c.probit);
}

// Billows above, inverted below: wisps. Large scale.
float cloud_shape_level(vec3 p_cam, float eta, float log2_footprint, inout float unknown) {
  float lod = max(log2_footprint - CLOUD.domains[kDomainShape].log2_texel_m, 0.0);
  float weight = kShapeWeight * CLOUD.shape_amount * smoothstep(0.0, 0.25, eta);
  if (lod > 4.5) {  // nothing of it left
    unknown += weight * weight;
    return 0.0;
  }
  float shape = (textureLod(cloud_shape, cloud_uvw(kDomainShape, p_cam), round(lod)).r - 0.5) * (2.0 * kNoiseRange);
  unknown += weight * weight * (1.0 - variance_left(lod, CLOUD.fade_start.z, CLOUD.fade_per_lod.z));
  return weight * shape;
}

float cloud_detail_level(vec3 p_cam, float eta, float log2_footprint, inout float unknown) {
  float lod = max(log2_footprint - CLOUD.domains[kDomainDetail].log2_texel_m, 0.0);
  float weight = kDetailWeight * CLOUD.detail_amount * mix(-1.0, 1.0, smoothstep(0.05, 0.3, eta));
  if (lod > 3.5) {
    unknown += weight * weight;
    return 0.0;
  }
  vec3 uvw = cloud_uvw(kDomainDetail, p_cam);
  float detail = (textureLod(cloud_detail, uvw, round(lod)).r - 0.5) * (2.0 * kNoiseRange);
  unknown += weight * weight * (1.0 - variance_left(lod, CLOUD.fade_start.w, CLOUD.fade_per_lod.w));
  float level = weight * detail;
  lod = log2_footprint - CLOUD.domains[kDomainFine].log2_texel_m;
  if (lod < 2.5) {
    float fine = (textureLod(cloud_detail, cloud_uvw(kDomainFine, p_cam), max(lod, 0.0)).r - 0.5) * (2.0 * kNoiseRange);
    level += kFineWeight * CLOUD.detail_amount * fine * smoothstep(2.5, 1.0, lod);
  }
  return level;
}

// Extinction from the level. Thin just inside the edge, growing inwards and with height as liquid water does.
struct CloudMedium {
  float sigma_per_m;  // what a ray sees: of clumps where they are unresolved
  float clump_depth;  // optical depth of one clump; towards 0 where everything is resolved
};

CloudMedium cloud_medium(float level, float unknown, float blur, float eta, float footprint_m) {
  float spread = sqrt(unknown + kEdge * kEdge + blur * blur);
  float share = share_above(level, spread);
  float inner = mix(clamp(0.35 + 1.6 * level, 0.25, 1.0), 1.0, clamp(2.0 * spread, 0.0, 1.0));
  float sigma = CLOUD.extinction_per_m * inner * (0.55 + 0.45 * clamp(2.0 * eta, 0.0, 1.0));
  float size_m = clamp(0.5 * footprint_m, 1.0, 0.42 * CLOUD.thickness_m);
  return CloudMedium(share > 0.0 ? clumped_extinction(share, sigma, size_m) : 0.0, sigma * size_m);
}

float cloud_extinction(float level, float unknown, float blur, float eta, float footprint_m) {
  return cloud_medium(level, unknown, blur, eta, footprint_m).sigma_per_m;
}

#endif
