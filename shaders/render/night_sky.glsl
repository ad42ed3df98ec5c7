// Stars, moon and airglow for every pass (docs/night_sky.md).
//
//   #define NIGHT_SKY_BINDING 20      // takes this binding and the two after it
//   #include "render/night_sky.glsl"
//
// NightSky::bind() declares the bindings. All luminances are linear Rec. 709, cd/m^2.
#ifndef NEPHO_RENDER_NIGHT_SKY_GLSL
#define NEPHO_RENDER_NIGHT_SKY_GLSL
#include "render/night_sky_shared.h"

layout(scalar, set = 0, binding = NIGHT_SKY_BINDING) uniform NightSkyBlock { NightSkyUniform night_sky_data; } night_sky;
layout(scalar, set = 0, binding = NIGHT_SKY_BINDING + 1) readonly buffer StarPixelBlock { uint values[]; } star_pixels;
layout(set = 0, binding = NIGHT_SKY_BINDING + 2) uniform sampler2D moon_map;

// Drawn stars and the even light of the fainter ones, outside the air: multiply by the transmittance of the air.
vec3 stars_luminance(FrameConstants f, ivec2 pixel) {
  uint at = 3u * night_sky.night_sky_data.star_stride * (uint(pixel.y) * f.size.x + uint(pixel.x));
  vec3 lux = vec3(star_pixels.values[at], star_pixels.values[at + 1u], star_pixels.values[at + 2u]) * night_sky.night_sky_data.star_unit_lux;
  return lux / pixel_solid_angle_sr(f, vec2(pixel) + 0.5) + night_sky.night_sky_data.starlight;
}

// Share of a pixel that the moon hides.
float moon_cover(FrameConstants f, vec3 dir) { return moon_disc_cover(f, dir) * night_sky.night_sky_data.moon_present; }

// The moon's disc, lit by the sun and the Earth, outside the air: multiply by the transmittance of the air. Phases of a
// disc of a few pixels become its mean.
vec3 moon_disc_luminance(FrameConstants f, vec3 dir) {
  NightSkyUniform n = night_sky.night_sky_data;
  float cover = moon_disc_cover(f, dir);
  if (cover <= 0.0) return vec3(0);
  float mu;
  vec3 normal = moon_normal(f, dir, mu);
  float pixels = f.moon_angular_radius_rad / f.pixel_angle_rad;
  float lod = log2(max(float(textureSize(moon_map, 0).y) / (kPi * max(pixels, 1.0e-3)), 1.0));
  float albedo = textureLod(moon_map, moon_map_uv(n.moon_from_ecef * normal), lod).r;
  float resolved = smoothstep(1.5, 4.0, pixels);
  float shading = mix(n.moon_mean, albedo * lunar_shading(dot(normal, n.sun_from_moon), mu, n.lunar_lambert), resolved);
  albedo = mix(n.moon_mean_albedo, albedo, resolved);
  return (shading * n.moon_luminance + albedo * n.earthshine_luminance) * (cover * moon_disc_dimming(f));
}

// Stars with the moon before them: all that stands behind the air but the sun.
vec3 night_bodies_luminance(FrameConstants f, ivec2 pixel, vec3 dir) {
  return stars_luminance(f, pixel) * (1.0 - moon_cover(f, dir)) + moon_disc_luminance(f, dir);
}

// The glowing layer 85 to 97 km up along a ray to space or, when hits_ground, to the ground. `transmittance` is the air's
// along the whole ray: what glows behind the ray's lowest point comes through it, what glows before does not.
vec3 airglow_luminance(FrameConstants f, vec3 dir, bool hits_ground, vec3 transmittance) {
  vec2 path = airglow_path_m(f.planet, dir, hits_ground) / (kAirglowTop_m - kAirglowBottom_m);
  return night_sky.night_sky_data.airglow * (path.x + path.y * transmittance);
}

// Light of airglow and stars that the air scatters into a ray with this transmittance. They shine from the whole sky, so that
// the source function is about their mean over all directions: half of that of the sky, and a tenth of it for the ground.
vec3 night_air_luminance(vec3 transmittance) {
  return night_sky.night_sky_data.night_illuminance * (0.55 / kPi) * (1.0 - transmittance);
}

// Light of airglow and stars on a horizontal plane at the ground, lux: the least light of any night.
vec3 night_illuminance_lux() { return night_sky.night_sky_data.night_illuminance; }
#endif
