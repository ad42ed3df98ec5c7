// Sky, aerial perspective and light from the atmosphere's tables, for every pass (docs/atmosphere.md).
//
//   #define ATMOSPHERE_BINDING 8      // takes this binding and the five after it
//   #include "atmosphere/atmosphere_lookup.glsl"
//
// AtmosphereTables::bind() declares the bindings. Luminances are linear Rec. 709 in cd/m^2, illuminances in lux per
// channel. Cameras may be anywhere from the ground to space. A ray that misses the air: luminance 0, transmittance 1.
//
// Tables serve rays that reach space from within the air. All other paths (to a point, to the ground, from space) are
// integrated over the tables of the sun's transmittance and of the source function: no two lookups are subtracted.
#ifndef NEPHO_ATMOSPHERE_LOOKUP_GLSL
#define NEPHO_ATMOSPHERE_LOOKUP_GLSL
#include "common/frame.h"
#include "atmosphere/atmosphere_shared.h"

layout(scalar, set = 0, binding = ATMOSPHERE_BINDING) uniform AtmosphereBlock { AtmosphereUniform atmosphere_data; } atmosphere;
layout(set = 0, binding = ATMOSPHERE_BINDING + 1) uniform sampler2D transmittance_tex;
layout(set = 0, binding = ATMOSPHERE_BINDING + 2) uniform sampler2D irradiance_tex;
layout(set = 0, binding = ATMOSPHERE_BINDING + 3) uniform sampler3D rayleigh_tex;
layout(set = 0, binding = ATMOSPHERE_BINDING + 4) uniform sampler3D mie_tex;
layout(set = 0, binding = ATMOSPHERE_BINDING + 5) uniform sampler3D multiple_tex;

#define AIR_PATH_NODES 8
#define SOURCE_TEX multiple_tex
#define SOURCE_ROW0 float(kSkyMu)
#define SOURCE_ROWS float(kMultipleRows)
#define SOURCE_SCALE kTableScale
#include "atmosphere/air_path.glsl"

// A ray's first point within the air.
struct AirRay {
  bool in_air;    // false: never enters it
  bool outside;   // the camera is above the air
  float start_m;  // distance from the camera to that point, true metres
  float stretch;  // scaled metres per true metre along the ray
  float h;        // scaled height, 0..top
  float mu;       // view zenith cosine in scaled space
  float mu_s;     // sun's cosine to the geodetic normal
  float nu;       // view-sun cosine
};

AirRay air_ray_from(PlanetView planet, vec3 up, vec3 sun_dir, vec3 dir) {
  AtmosphereUniform air = atmosphere.atmosphere_data;
  vec3 scaled = scaled_from_cam(planet, dir);
  AirRay ray;
  ray.in_air = true;
  ray.outside = false;
  ray.start_m = 0.0;
  ray.stretch = length(scaled);
  // A micrometre along the ray: a condition that depends on uniforms alone makes Mesa's software driver compile the shader
  // anew, for seconds, for each of their values (it folds them in); this one also depends on the pixel.
  ray.h = max(scaled_height_from_f(planet, planet_f(planet, 1.0e-6 * dir)), 0.0);
  ray.nu = clamp(dot(dir, sun_dir), -1.0, 1.0);
  vec3 q = planet.camera_q_m;
  if (ray.h > air.top_m) {
    vec2 t;
    ray.outside = true;
    ray.in_air = intersect_shell(planet, dir, air.top_m, t) && t.y > 0.0;
    ray.start_m = max(t.x, 0.0);
    ray.h = air.top_m;
    q += scaled * ray.start_m;
    up = normalize(vec3(q.x, q.y, q.z * planet.a_over_b));
  }
  ray.mu = clamp(dot(normalize(q), scaled / ray.stretch), -1.0, 1.0);
  if (ray.outside) ray.mu = min(ray.mu, 0.0);  // it goes in
  ray.mu_s = clamp(dot(up, sun_dir), -1.0, 1.0);
  return ray;
}
AirRay air_ray(FrameConstants frame, vec3 dir) {
  return air_ray_from(frame.planet, frame.camera_up, frame.sun_dir, dir);
}

// Spectral radiance, W m^-2 sr^-1 nm^-1 for the sun at 1 au, of `length_m` scaled metres of the ray from its first point.
vec3 path_radiance(AirRay ray, float length_m, out vec3 transmittance) {
  AtmosphereUniform air = atmosphere.atmosphere_data;
  ScatteredLight light = scatter_along(air, ray.h, ray.mu, ray.mu_s, ray.nu, length_m, true, true);
  transmittance = exp(-light.optical_depth);
  return light.rayleigh * phase_rayleigh(ray.nu) + light.mie * phase_cornette_shanks(ray.nu, air.mie_g) + light.multiple;
}

// The same from h to space, by the tables.
vec3 sky_radiance_within(AirRay ray, out vec3 transmittance) {
  AtmosphereUniform air = atmosphere.atmosphere_data;
  transmittance = exp(-sampled_optical_depth_to_top(air, ray.h, ray.mu));
  float unit_mu = unit_from_sky_mu(air, ray.h, ray.mu);
  float unit_mu_s = unit_from_mu_s(air, ray.mu_s);
  float unit_nu = unit_from_nu(ray.nu);
  float w = texel_coord(unit_from_height(air, ray.h), kAirR);
  float v = texel_coord(unit_mu, kSkyMu);
  vec3 rayleigh = sample_4d(rayleigh_tex, unit_nu, unit_mu_s, v, w);
  vec3 mie = sample_4d(mie_tex, unit_nu, unit_mu_s, v, w);
  vec3 multiple = sample_4d(multiple_tex, unit_nu, unit_mu_s, v * float(kSkyMu) / float(kMultipleRows), w);
  return (rayleigh * phase_rayleigh(ray.nu) + mie * phase_cornette_shanks(ray.nu, air.mie_g) + multiple) * (1.0 / kTableScale);
}

// Spectral radiance of the sky without the sun's disc, to space or, when hits_ground, to the ellipsoid.
vec3 sky_radiance(AirRay ray, bool hits_ground, out vec3 transmittance) {
  AtmosphereUniform air = atmosphere.atmosphere_data;
  transmittance = vec3(1);
  if (!ray.in_air) return vec3(0);
  // From space the tables are coarse in the height of the lowest point: integrate.
  if (!hits_ground && !ray.outside) return sky_radiance_within(ray, transmittance);
  return path_radiance(ray, hits_ground ? distance_to_ground(air, ray.h, ray.mu) : distance_to_top(air, ray.h, ray.mu), transmittance);
}

// Luminance of the sky from the camera to space or, when hits_ground, to the ellipsoid; without the sun's disc.
vec3 sky_luminance(FrameConstants frame, vec3 dir, bool hits_ground, out vec3 transmittance) {
  vec3 radiance = sky_radiance(air_ray(frame, dir), hits_ground, transmittance);
  return radiance * atmosphere.atmosphere_data.sky_luminance_factor * frame.sun_distance_factor;
}

// Luminance of the sun's disc in direction `dir`, 0 outside it. The edge is smoothed over a pixel; a disc smaller than a
// pixel keeps its illuminance. Limb darkening: Hestroffer and Magnan 1998, I = cos^a, normalised.
vec3 sun_disc_luminance(FrameConstants frame, vec3 dir, vec3 transmittance) {
  float pixel = max(frame.pixel_angle_rad, 1.0e-7);
  float radius = max(frame.sun_angular_radius_rad, 0.5 * pixel);
  float angle = 2.0 * asin(min(0.5 * length(dir - frame.sun_dir), 1.0));
  float cover = clamp((radius - angle) / pixel + 0.5, 0.0, 1.0);
  if (cover <= 0.0) return vec3(0);
  const vec3 exponent = vec3(0.397, 0.503, 0.652);
  float x = min(angle / radius, 1.0);
  vec3 limb = pow(vec3(sqrt(max(1.0 - x * x, 1.0e-4))), exponent) * (0.5 * exponent + 1.0);
  return frame.sun_illuminance / (kPi * radius * radius) * limb * transmittance * cover;
}

// Spectral radiance scattered into the ray between the camera and the point at `distance_m` true metres.
vec3 radiance_to_point(AirRay ray, float distance_m, out vec3 transmittance) {
  float length_m = (distance_m - ray.start_m) * ray.stretch;
  transmittance = vec3(1);
  if (!ray.in_air || !(length_m > 0.0)) return vec3(0);
  return path_radiance(ray, min(length_m, distance_to_top(atmosphere.atmosphere_data, ray.h, ray.mu)), transmittance);
}

// In-scattered luminance between the camera and the point at `distance_m` true metres along `dir`, and the transmittance
// between them.
vec3 aerial_perspective(FrameConstants frame, vec3 dir, float distance_m, out vec3 transmittance) {
  return radiance_to_point(air_ray(frame, dir), distance_m, transmittance) *
         atmosphere.atmosphere_data.sky_luminance_factor * frame.sun_distance_factor;
}

// Share of sunlight that reaches a height, ground to space, with the part of the disc above the planet's horizon.
vec3 sun_transmittance(float height_m, float mu_s) {
  AtmosphereUniform air = atmosphere.atmosphere_data;
  float h = max(height_m, 0.0);
  float visible = sun_visibility(air, h, mu_s);
  if (h > air.top_m) {
    float r_mu = (air.radius_m + h) * mu_s;
    float gap2 = (h - air.top_m) * (2.0 * air.radius_m + h + air.top_m);  // r^2 - r_top^2
    float inside = r_mu * r_mu - gap2;
    if (r_mu >= 0.0 || inside <= 0.0) return vec3(1);
    float t = gap2 / (sqrt(inside) - r_mu);
    mu_s = clamp((r_mu + t) / (air.radius_m + air.top_m), -1.0, 0.0);
    h = air.top_m;
  }
  return visible * exp(-sampled_optical_depth_to_top(air, h, mu_s));
}

// Sunlight on a facing plane, lux per channel.
vec3 sun_illuminance(FrameConstants frame, float height_m, float mu_s) {
  return frame.sun_illuminance * sun_transmittance(height_m, mu_s);
}

vec3 irradiance_part(float height_m, float mu_s, int part) {
  AtmosphereUniform air = atmosphere.atmosphere_data;
  float v = (float(part * kAirR) + 0.5 + unit_from_height(air, clamp(height_m, 0.0, air.top_m)) * float(kAirR - 1)) /
            float(kIrradianceParts * kAirR);
  return textureLod(irradiance_tex, vec2(texel_coord(unit_from_mu_s(air, mu_s), kAirMuS), v), 0.0).rgb;
}

// Light of the sky, sun excluded, on a horizontal plane, lux per channel.
vec3 sky_illuminance(FrameConstants frame, float height_m, float mu_s) {
  return irradiance_part(height_m, mu_s, 0) * atmosphere.atmosphere_data.sky_luminance_factor * frame.sun_distance_factor;
}

// Mean luminances of the hemispheres above and below the horizontal, without the sun's disc; below includes the light of
// the ground, with the planet's mean albedo.
void hemisphere_luminances(FrameConstants frame, float height_m, float mu_s, out vec3 above, out vec3 below) {
  vec3 factor = atmosphere.atmosphere_data.sky_luminance_factor * frame.sun_distance_factor;
  above = irradiance_part(height_m, mu_s, 1) * factor;
  below = irradiance_part(height_m, mu_s, 2) * factor;
}

// Mean over all directions.
vec3 mean_sky_luminance(FrameConstants frame, float height_m, float mu_s) {
  vec3 above, below;
  hemisphere_luminances(frame, height_m, mu_s, above, below);
  return 0.5 * (above + below);
}

// Luminance of the sky in direction `dir` seen from another point within the air, camera-relative metres; `dir` must be
// above the horizon there. For reflections in water, and light on clouds.
vec3 sky_luminance_at(FrameConstants frame, vec3 point_cam_m, vec3 dir) {
  AtmosphereUniform air = atmosphere.atmosphere_data;
  vec3 q = frame.planet.camera_q_m + scaled_from_cam(frame.planet, point_cam_m);
  AirRay ray;
  ray.in_air = true;
  ray.outside = false;
  ray.start_m = 0.0;
  ray.stretch = 1.0;
  ray.h = clamp(scaled_height_from_f(frame.planet, planet_f(frame.planet, point_cam_m)), 0.0, air.top_m);
  ray.mu = clamp(dot(normalize(q), normalize(scaled_from_cam(frame.planet, dir))), -1.0, 1.0);
  ray.mu_s = clamp(dot(geodetic_up(frame.planet, point_cam_m), frame.sun_dir), -1.0, 1.0);
  ray.nu = clamp(dot(dir, frame.sun_dir), -1.0, 1.0);
  vec3 transmittance;
  return sky_radiance_within(ray, transmittance) * air.sky_luminance_factor * frame.sun_distance_factor;
}
#endif
