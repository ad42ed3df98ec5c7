// Sky, aerial perspective and light from the atmosphere's tables, for every pass (docs/atmosphere.md).
//
//   #define ATMOSPHERE_BINDING 8      // takes this binding and the six after it
//   #include "atmosphere/atmosphere_lookup.glsl"
//
// With ATMOSPHERE_MANY_VIEWS the sky views are a storage buffer of any length instead of a frame's two.
//
// Specialisation constant 0 is the number of spectral groups. AtmosphereTables::bind() declares the bindings. Luminances are
// linear Rec. 709 in cd/m^2, illuminances in lux per channel. Cameras may be anywhere from the ground to space. A ray that
// misses the air: luminance 0, transmittance 1.
//
// The sky seen from low in the air (sky_view_top_m) comes from a sky view, integrated for the camera before the frame (sky_view.comp). All
// other paths (to a point, to the ground, from space) are integrated here: no two lookups are subtracted.
#ifndef NEPHO_ATMOSPHERE_LOOKUP_GLSL
#define NEPHO_ATMOSPHERE_LOOKUP_GLSL
#include "common/frame.h"
#include "atmosphere/atmosphere_light.glsl"
layout(set = 0, binding = ATMOSPHERE_BINDING + 3) uniform sampler2D irradiance_tex;
layout(set = 0, binding = ATMOSPHERE_BINDING + 4) uniform sampler3D mirror_tex;
layout(set = 0, binding = ATMOSPHERE_BINDING + 5) uniform sampler2D sky_view_tex;
#ifdef ATMOSPHERE_MANY_VIEWS
layout(set = 0, binding = ATMOSPHERE_BINDING + 6, scalar) readonly buffer SkyViewBlock { SkyView data[]; } sky_views;
#else
layout(set = 0, binding = ATMOSPHERE_BINDING + 6, scalar) uniform SkyViewBlock { SkyView data[2]; } sky_views;  // sun's, moon's
#endif

// A ray's first point within the air, and one light.
struct AirRay {
  bool in_air;    // false: never enters it
  bool outside;   // the camera is above the air
  bool has_view;  // the camera has sky views
  float start_m;  // distance from the camera to that point, true metres
  float stretch;  // scaled metres per true metre along the ray
  float h;        // scaled height, 0..top
  float mu;       // view zenith cosine in scaled space
  float mu_s;     // light's cosine to the geodetic normal
  float nu;       // view-light cosine
};

// `up` is the geodetic normal at the camera; that of the first point comes back in it.
AirRay air_ray_geometry(PlanetView planet, inout vec3 up, vec3 dir) {
  float top_m = atmosphere.air.top_m;
  vec3 scaled = scaled_from_cam(planet, dir);
  AirRay ray;
  ray.in_air = true;
  ray.outside = false;
  ray.has_view = false;
  ray.start_m = 0.0;
  ray.stretch = length(scaled);
  // A micrometre along the ray: a condition that depends on uniforms alone makes Mesa's software driver compile the shader
  // anew, for seconds, for each of their values (it folds them in); this one also depends on the pixel.
  ray.h = max(scaled_height_from_f(planet, planet_f(planet, 1.0e-6 * dir)), 0.0);
  ray.has_view = ray.h <= atmosphere.air.sky_view_top_m;
  vec3 q = planet.camera_q_m;
  if (ray.h > top_m) {
    vec2 t;
    ray.outside = true;
    ray.in_air = intersect_shell(planet, dir, top_m, t) && t.y > 0.0;
    ray.start_m = max(t.x, 0.0);
    ray.h = top_m;
    q += scaled * ray.start_m;
    up = normalize(vec3(q.x, q.y, q.z * planet.a_over_b));
  }
  ray.mu = clamp(dot(normalize(q), scaled / ray.stretch), -1.0, 1.0);
  if (ray.outside) ray.mu = min(ray.mu, 0.0);  // it goes in
  ray.mu_s = 0.0;
  ray.nu = 0.0;
  return ray;
}
AirRay air_ray_from(PlanetView planet, vec3 up, vec3 light_dir, vec3 dir) {
  AirRay ray = air_ray_geometry(planet, up, dir);
  ray.mu_s = clamp(dot(up, light_dir), -1.0, 1.0);
  ray.nu = clamp(dot(dir, light_dir), -1.0, 1.0);
  return ray;
}

// The light of `length_m` scaled metres of the ray from its first point, of which the last shadow_m get no sunlight.
vec3 path_light(AirRay ray, float length_m, float shadow_m, out vec3 columns) {
  ScatteredLight light = scatter_along(ray.h, ray.mu, ray.mu_s, ray.nu, length_m, length_m - shadow_m, phase_rayleigh(ray.nu), 1.0);
  columns = light.columns;
  return light.smooth_part + light.mie * phase_aerosol(atmosphere.air, ray.nu);
}

// The sky from within the air by a sky view, and the transmittance to space. `dir` is a unit vector.
vec3 sky_view_light(SkyView view, vec3 dir, out vec3 transmittance) {
  vec3 scaled = vec3(dir.x, dir.y, dir.z * view.a_over_b);
  vec2 uv = view.uv_origin +
            view.uv_span * sky_view_unit(view, dot(scaled, view.forward), dot(scaled, view.side), dot(scaled, view.up));
  vec3 smooth_part = textureLod(sky_view_tex, uv, 0.0).rgb;
  vec3 mie = textureLod(sky_view_tex, vec2(uv.x, uv.y + view.part_v), 0.0).rgb;
  transmittance = textureLod(sky_view_tex, vec2(uv.x, uv.y + 2.0 * view.part_v), 0.0).rgb;
  return smooth_part + mie * phase_aerosol(atmosphere.air, clamp(dot(dir, view.light_dir), -1.0, 1.0));
}

// Light of the sky without discs and stars, to space or, when hits_ground, to the ellipsoid, and the transmittance. `view` is
// the camera's sky view.
vec3 sky_light(AirRay ray, vec3 dir, SkyView view, bool hits_ground, out vec3 transmittance) {
  transmittance = vec3(1);
  vec3 light = vec3(0);
  if (!ray.in_air) return light;
  if (ray.has_view && !hits_ground) {
    light = sky_view_light(view, dir, transmittance);
  } else {
    float length_m = hits_ground ? distance_to_ground(atmosphere.air, ray.h, ray.mu) : distance_to_top(atmosphere.air, ray.h, ray.mu);
    vec3 columns;
    light = path_light(ray, length_m, 0.0, columns);
    transmittance = transmittance_of(columns);
  }
  return light;
}

// Light scattered into the ray between the camera and the point at `distance_m` true metres, before which sunlight ends
// shadow_m earlier.
vec3 light_to_point(AirRay ray, float distance_m, float shadow_m, out vec3 columns) {
  float length_m = (distance_m - ray.start_m) * ray.stretch;
  columns = vec3(0);
  if (!ray.in_air || !(length_m > 0.0)) return vec3(0);
  return path_light(ray, min(length_m, distance_to_top(atmosphere.air, ray.h, ray.mu)), shadow_m * ray.stretch, columns);
}

// --- with the lights of a frame ------------------------------------------------------------------------------------

// Number of lights. Mesa's software driver compiles a shader anew, or spends 10 ms to find that it has, for every value of a
// uniform that a condition depends on alone; this one also depends on a number in [-1, 1] of the pixel.
int count_lights(FrameConstants frame, float of_pixel) { return int(frame.light_count) + int(0.5 * of_pixel); }
vec3 light_dir(FrameConstants frame, int light) { return light == 0 ? frame.sun_dir : frame.moon_dir; }
// Of the light per sunlight at 1 au, times the factor to luminance.
vec3 light_factor(FrameConstants frame, int light) {
  return atmosphere.air.luminance_factor * (light == 0 ? vec3(frame.sun_distance_factor) : frame.moon_share);
}

// Luminance of the air in a pixel, without discs and stars, and the transmittance behind it: to space, or to the point at
// `distance_m` true metres along `dir`.
vec3 air_luminance(FrameConstants frame, vec3 dir, bool to_space, float distance_m, out vec3 transmittance) {
  vec3 luminance = vec3(0);
  for (int i = 0; i < count_lights(frame, dir.x); ++i) {
    AirRay ray = air_ray_from(frame.planet, frame.camera_up, light_dir(frame, i), dir);
    bool by_view = to_space && ray.has_view;
    float length_m = distance_to_top(atmosphere.air, ray.h, ray.mu);
    if (!to_space) length_m = min((distance_m - ray.start_m) * ray.stretch, length_m);
    vec3 columns;
    vec3 light = path_light(ray, ray.in_air && !by_view ? max(length_m, 0.0) : 0.0, 0.0, columns);
    transmittance = transmittance_of(ray.in_air ? columns : vec3(0));
    if (by_view) light = sky_view_light(sky_views.data[i], dir, transmittance);
    luminance += light * light_factor(frame, i);
  }
  return luminance;
}

// The same for a ray to space from a camera that has sky views: three reads per light. `moon` is a constant, false where
// light_count is known to be 1.
vec3 sky_view_luminance(FrameConstants frame, vec3 dir, const bool moon, out vec3 transmittance) {
  vec3 luminance = sky_view_light(sky_views.data[0], dir, transmittance) * light_factor(frame, 0);
  if (moon && count_lights(frame, dir.x) > 1) luminance += sky_view_light(sky_views.data[1], dir, transmittance) * light_factor(frame, 1);
  return luminance;
}

// Transmittance of the air along the whole ray to space.
vec3 transmittance_to_space(FrameConstants frame, vec3 dir) {
  AtmosphereUniform air = atmosphere.air;
  AirRay ray = air_ray_from(frame.planet, frame.camera_up, frame.sun_dir, dir);
  if (!ray.in_air) return vec3(1);
  if (!ray.outside) return transmittance_of(sampled_columns_to_top(air, ray.h, ray.mu));
  // In from the top and out again: twice the columns from the lowest point.
  float low_m = -(air.radius_m + ray.h) * ray.mu;
  return transmittance_of(2.0 * sampled_columns_to_top(air, height_along(air, ray.h, ray.mu, low_m), 0.0));
}

// In-scattered luminance between the camera and the point at `distance_m` true metres along `dir`, and the transmittance
// between them. The last shadow_m before the point get no direct sunlight (0 without cloud shadows).
vec3 aerial_perspective(FrameConstants frame, vec3 dir, float distance_m, float shadow_m, out vec3 transmittance) {
  vec3 luminance = vec3(0);
  vec3 columns = vec3(0);
  for (int i = 0; i < count_lights(frame, dir.x); ++i) {
    AirRay ray = air_ray_from(frame.planet, frame.camera_up, light_dir(frame, i), dir);
    luminance += light_to_point(ray, distance_m, shadow_m, columns) * light_factor(frame, i);
  }
  transmittance = transmittance_of(columns);
  return luminance;
}

// Luminance of the sun's disc in direction `dir`, 0 outside it. The edge is smoothed over a pixel; a disc smaller than a
// pixel keeps its illuminance. Limb darkening: Hestroffer and Magnan 1998, I = cos^a, normalised.
vec3 sun_disc_luminance(FrameConstants frame, vec3 dir, vec3 transmittance) {
  float pixel = max(frame.pixel_angle_rad, 1.0e-7);
  float radius = max(frame.sun_angular_radius_rad, 0.5 * pixel);
  float chord = length(dir - frame.sun_dir);
  if (chord > 2.0 * (radius + pixel)) return vec3(0);
  float angle = 2.0 * asin(0.5 * chord);
  float cover = clamp((radius - angle) / pixel + 0.5, 0.0, 1.0);
  if (cover <= 0.0) return vec3(0);
  const vec3 exponent = vec3(0.397, 0.503, 0.652);
  float x = min(angle / radius, 1.0);
  vec3 limb = pow(vec3(sqrt(max(1.0 - x * x, 1.0e-4))), exponent) * (0.5 * exponent + 1.0);
  return frame.sun_illuminance / (kPi * radius * radius) * limb * transmittance * cover;
}

// Share of a light that reaches a height, ground to space, with the part of the sun's disc above the planet's horizon (the
// moon's is as large).
vec3 sun_transmittance(float height_m, float mu_s) {
  AtmosphereUniform air = atmosphere.air;
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
  return visible * transmittance_of(sampled_columns_to_top(air, h, mu_s));
}

// Light of the one that casts shadows, on a facing plane, lux per channel. `mu` is its cosine to the vertical there.
vec3 key_illuminance(FrameConstants frame, float height_m, float mu) { return frame.key_illuminance * sun_transmittance(height_m, mu); }

// Light of the moon on a horizontal plane, lux per channel, as far as it is not the key light: at dusk, before and while it takes
// over from the sun. It has no shadows. Arithmetic, because of count_lights().
vec3 moon_fill_illuminance(FrameConstants frame, float height_m, vec3 up) {
  float mu = dot(up, frame.moon_dir);
  vec3 rest = frame.moon_share * frame.sun_illuminance_1au - step(0.99999, dot(frame.key_dir, frame.moon_dir)) * frame.key_illuminance;
  return step(1.5, float(frame.light_count)) * max(mu, 0.0) * max(rest, vec3(0.0)) * sun_transmittance(height_m, mu);
}

// One of the kIrradianceParts for a sun at 1 au.
vec3 irradiance_part(float height_m, float mu_s, int part) {
  AtmosphereUniform air = atmosphere.air;
  float v = (float(part * kAirR) + 0.5 + unit_from_height(air, clamp(height_m, 0.0, air.top_m)) * float(kAirR - 1)) /
            float(kIrradianceParts * kAirR);
  vec4 coefficients = textureLod(irradiance_tex, vec2(texel_coord(unit_from_mu_s(air, mu_s), kAirMuS), v), 0.0);
  vec3 sum = vec3(0);
  for (int g = 0; g < kSpectralGroups; ++g) {
    SpectralGroup group = atmosphere.spectrum[g];
    sum += group.rgb * (group.solar_irradiance * exp(group.basis * coefficients));
  }
  return max(sum, vec3(0)) * night_fade(air, mu_s);
}
vec3 irradiance_of_lights(FrameConstants frame, float height_m, vec3 up, int part) {
  vec3 sum = vec3(0);
  for (int i = 0; i < count_lights(frame, up.x); ++i)
    sum += irradiance_part(height_m, dot(up, light_dir(frame, i)), part) * light_factor(frame, i);
  return sum;
}

// Light of the sky, sun and moon excluded, on a horizontal plane, lux per channel. `up` is the geodetic normal there.
vec3 sky_illuminance(FrameConstants frame, float height_m, vec3 up) { return irradiance_of_lights(frame, height_m, up, 0); }

// Luminance of the sky that a point of the surface mirrors: seen from sea level with the lights' zenith angles there.
// `up` is the geodetic normal at the point, dir is above the horizontal.
vec3 mirrored_sky_luminance(FrameConstants frame, vec3 up, vec3 dir) {
  AtmosphereUniform air = atmosphere.air;
  float v = texel_coord(unit_from_sky_mu(air, 0.0, max(dot(up, dir), 0.0)), kMirrorMu);
  vec3 sum = vec3(0);
  for (int i = 0; i < count_lights(frame, dir.x); ++i) {
    vec3 light = light_dir(frame, i);
    float nu = clamp(dot(dir, light), -1.0, 1.0);
    float x = unit_from_nu(nu), y = unit_from_mu_s(air, dot(up, light));
    vec3 gas = sample_4d(mirror_tex, x, y, v, 0.5 / 3.0).rgb;
    vec3 mie = sample_4d(mirror_tex, x, y, v, 1.5 / 3.0).rgb;
    vec3 multiple = sample_4d(mirror_tex, x, y, v, 2.5 / 3.0).rgb;
    sum += (gas * phase_rayleigh(nu) + mie * phase_aerosol(air, nu) + multiple) * night_fade(air, dot(up, light)) * light_factor(frame, i);
  }
  return max(sum, vec3(0));
}
#endif
