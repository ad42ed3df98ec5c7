// What shade and haze change of the light that the air sends along a ray. Needs `frame`, SHAFT_BINDING and
// atmosphere/atmosphere_lookup.glsl before it, and AIR_VISIBLE(p_cam): the share of the key light that clouds and terrain let through to a point.
//
// A picture of clear air without shade is B. With it, it is T_haze B + change: the change is
//   integral of [haze source + single (V T - 1) + multiple (T - 1)] + (1 - T_haze) integral of [single + multiple]
// with T the haze's transmittance so far and V the visible share of the light; without haze it is minus the lost single scattering.
#include "render/shaft_shared.h"
layout(scalar, set = 0, binding = SHAFT_BINDING) uniform ShaftBlock { ShaftData data; } shafts;
layout(constant_id = 6) const uint HAZE = 0u;        // layers of haze
layout(constant_id = 7) const uint SHAFT_STEPS = 32u;
layout(constant_id = 10) const bool QUICK = false;   // of a sequence

const int kGroup = 4;                  // steps at whose ends clear air is known

struct AirMarch {
  AirRay ray;
  AirPath path;
  vec3 dir;
  vec3 factor;        // luminance of the key light's share of sunlight
  float end_m;        // of the ray within the air, true metres
  float haze_per_m;   // of the haze's optical depth, from a column in scaled metres
};

AirMarch start_air_march(vec3 dir) {
  FrameConstants f = frame.frame_data;
  AirMarch m;
  m.dir = dir;
  m.ray = air_ray_from(f.planet, f.camera_up, f.key_dir, dir);
  float length_m = m.ray.in_air ? distance_to_top(atmosphere.air, m.ray.h, m.ray.mu) : 0.0;
  m.path = air_path(atmosphere.air, m.ray.h, m.ray.mu, m.ray.mu_s, m.ray.nu, length_m, length_m);
  m.factor = f.key_illuminance / max(f.sun_illuminance_1au, vec3(1.0e-20)) * atmosphere.air.luminance_factor;
  m.end_m = m.ray.start_m + length_m / m.ray.stretch;
  m.haze_per_m = 1.0 / m.ray.stretch;
  return m;
}

// Optical depth of the haze between the camera and a distance.
float haze_depth_to(AirMarch m, float t_m) {
  float depth = 0.0;
  float length_m = max(t_m - m.ray.start_m, 0.0) * m.ray.stretch;
  for (uint l = 0u; l < HAZE; ++l)
    depth += shafts.data.haze.layers[l].extinction_per_m * m.haze_per_m *
             haze_column(shafts.data.haze.layers[l], shafts.data.haze.radius_m, m.ray.h, m.ray.mu, length_m);
  return depth;
}

struct AirSource {
  vec3 single;    // light scattered once, per metre, through the air before it
  vec3 multiple;  // more than once; only with haze
  vec3 haze;      // of haze where it is opaque at once, lit by the key light that clouds let through
  vec3 haze_sky;  // the same by the sky and the ground
};

AirSource air_source_at(AirMarch m, float t_m, bool many) {
  FrameConstants f = frame.frame_data;
  AtmosphereUniform air = atmosphere.air;
  float s = max(t_m - m.ray.start_m, 0.0) * m.ray.stretch;
  float r = air.radius_m + m.ray.h;
  float h = height_along(air, m.ray.h, m.ray.mu, s);
  float inv_r = 1.0 / (air.radius_m + h);
  AirNode node;
  node.h = h;
  node.mu = clamp((r * m.ray.mu + s) * inv_r, -1.0, 1.0);
  node.mu_s = clamp((r * m.ray.mu_s + s * m.ray.nu) * inv_r, -1.0, 1.0);
  node.density = densities(air, h);
  node.columns = columns_along(m.path, node.mu, sampled_columns_to_top(air, h, abs(node.mu)));
  node.columns_to_sun = sampled_columns_to_top(air, h, node.mu_s);
  node.sunlit = sun_visibility(air, h, node.mu_s);
  vec2 phase = vec2(phase_rayleigh(m.ray.nu), phase_aerosol(air, m.ray.nu));
  vec4 again = many ? sampled_source(air, source_tex, node, m.ray.nu) : vec4(0.0);
  AirSource source = AirSource(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
  for (int g = 0; g < kSpectralGroups; ++g) {
    SpectralGroup group = atmosphere.spectrum[g];
    vec3 gas = node.density.x * group.rayleigh_scattering_per_m, aerosol = node.density.y * group.mie_scattering_per_m;
    vec3 sun = node.sunlit * group.solar_irradiance * exp(-optical_depth(group, node.columns + node.columns_to_sun));
    source.single += group.rgb * ((phase.x * gas + phase.y * aerosol) * sun);
    if (many)
      source.multiple += group.rgb * ((gas + aerosol) * night_fade(air, node.mu_s) * group.solar_irradiance *
                                      exp(group.basis * again - optical_depth(group, node.columns)));
  }
  source.single *= m.factor * m.ray.stretch;
  source.multiple *= m.factor * m.ray.stretch;
  if (HAZE > 0u) {
    vec3 through = transmittance_of(node.columns);
    vec3 up = geodetic_up(f.planet, m.dir * t_m);
    vec3 key = f.key_illuminance * (node.sunlit * transmittance_of(node.columns_to_sun));
    vec3 sky = sky_illuminance(f, h, up) + moon_fill_illuminance(f, h, up) + f.night_illuminance;
    float mu0 = max(node.mu_s, 0.03);
    // Towards the light, through all layers: true, and of the medium without its forward peak (g^2); and vertically, isotropic (g).
    vec2 to_sun = vec2(0.0), column = vec2(0.0);
    float extinction = 1.0e-12, albedo = 0.0;
    for (uint l = 0u; l < HAZE; ++l) {
      HazeLayerData layer = shafts.data.haze.layers[l];
      float along = layer.extinction_per_m * haze_column(layer, shafts.data.haze.radius_m, h, node.mu_s, 1.0e7);
      to_sun += along * vec2(1.0, 1.0 - layer.albedo * layer.g * layer.g);
      column += layer.extinction_per_m * (1.0 - layer.albedo * layer.g) * vec2(haze_column_above(layer, h), haze_column_above(layer, min(h, shafts.data.ground_m)));
      float here = layer.extinction_per_m * haze_density(layer, h);
      extinction += here;
      albedo += here * haze_isotropic_albedo(layer.albedo, layer.g);
    }
    albedo /= extinction;
    column = min(column, vec2(60.0));
    vec2 beam = exp(-min(to_sun, vec2(80.0)));
    float survival = haze_survival(min(albedo, 1.0), column.y);
    HazeDiffuse diffuse = haze_diffuse_beam(column.x, column.y, mu0);
    float direct = 0.0, scattering = 0.0;
    for (uint l = 0u; l < HAZE; ++l) {
      HazeLayerData layer = shafts.data.haze.layers[l];
      float here = layer.extinction_per_m * haze_density(layer, h) * layer.albedo;
      scattering += here;
      direct += here * (phase_hg(m.ray.nu, layer.g) * beam.x + phase_hg(m.ray.nu, layer.g * abs(layer.g)) * (beam.y - beam.x));
    }
    float isotropic = scattering / (4.0 * kPi) / extinction;
    vec3 ground = shafts.data.ground_albedo * (key * (mu0 * exp(-column.y / mu0) + diffuse.ground * survival) + sky * haze_sky_flux(column.y));
    source.haze = through * key * (direct / extinction + isotropic * survival * diffuse.fluence);
    source.haze_sky = through * isotropic * (sky * mix(2.0, haze_sky_fluence(column.y - column.x, column.y), survival) + ground * haze_sky_fluence(column.x, column.y));
  }
  return source;
}

// Single scattering between two points of a ray, as an exponential of the distance.
struct AirStretch {
  float from_m, to_m;
  vec3 from, to;
};
AirStretch start_air_stretch(AirMarch m, float t_m) {
  vec3 single = HAZE > 0u ? vec3(0.0) : air_source_at(m, t_m, false).single;
  return AirStretch(t_m, t_m, single, single);
}
void next_air_stretch(AirMarch m, inout AirStretch stretch, float t_m) {
  stretch.from_m = stretch.to_m;
  stretch.from = stretch.to;
  stretch.to_m = t_m;
  stretch.to = air_source_at(m, t_m, false).single;
}
vec3 air_stretch_single(AirStretch stretch, float t_m) {
  float u = (t_m - stretch.from_m) / max(stretch.to_m - stretch.from_m, 1.0e-3);
  // Saturated colours may be negative; they are no exponentials.
  vec3 even = exp2(mix(log2(max(stretch.from, vec3(1.0e-30))), log2(max(stretch.to, vec3(1.0e-30))), u));
  return mix(even, mix(stretch.from, stretch.to, u), vec3(lessThanEqual(min(stretch.from, stretch.to), vec3(0.0))));
}

// The part of a ray up to `far_m` that shade or haze may reach, cut where most of the haze begins and ends.
bool shaft_stretch(AirMarch m, float far_m, out StepPlan plan) {
  PlanetView planet = frame.frame_data.planet;
  AtmosphereUniform air = atmosphere.air;
  vec2 hull, bulk;
  vec4 cut = vec4(0.0);
  float top_m = HAZE > 0u ? max(shafts.data.haze.top_m, shafts.data.shade_top_m) : shafts.data.shade_top_m;
  bool meets = intersect_shell(planet, m.dir, top_m, hull) && hull.y > 0.0;
  cut.x = max(hull.x, 0.0);
  // Of a block seen from orbit the farthest pixel may lie far beyond where this ray meets the sea: below there is no air.
  vec2 sea;
  float end_m = intersect_shell(planet, m.dir, min(shafts.data.ground_m, 0.0), sea) && sea.x > 0.0 ? min(m.end_m, sea.x) : m.end_m;
  cut.w = max(min(min(hull.y, far_m), end_m), cut.x);
  cut.yz = cut.xw;
  vec3 extinction = vec3(0.0);
  if (HAZE > 0u && intersect_shell(planet, m.dir, shafts.data.haze.bulk_m, bulk) && bulk.y > 0.0) {
    cut.yz = clamp(vec2(bulk.x, bulk.y), cut.xx, cut.ww);
    float depth = haze_depth_to(m, cut.z) - haze_depth_to(m, cut.y);
    extinction.y = depth / max(cut.z - cut.y, 1.0);
  }
  // Steps follow the transmittance of air as dense as where the ray begins.
  SpectralGroup group = atmosphere.spectrum[kSpectralGroups / 2];
  extinction += optical_depth(group, densities(air, height_along(air, m.ray.h, m.ray.mu, max(cut.x - m.ray.start_m, 0.0) * m.ray.stretch))).y;
  float groups = ceil(float(SHAFT_STEPS) / float(kGroup));
  float steps = groups * float(kGroup);
  plan = plan_steps(cut, extinction, steps);
  return meets && m.ray.in_air && cut.w > cut.x;
}

// Mean of exp(-depth) over a step in which depth grows evenly.
float mean_transmittance(float t0, float t1, float growth) { return growth > 1.0e-3 ? (t0 - t1) / growth : 0.5 * (t0 + t1); }
