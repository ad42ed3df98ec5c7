// Stars, moon and airglow for every pass (docs/night_sky.md).
//
//   #define NIGHT_SKY_BINDING 20      // takes this binding and the next
//   #include "render/night_sky.glsl"
//
// NightSky::bind() declares the bindings. All luminances are linear Rec. 709, cd/m^2.
#ifndef NEPHO_RENDER_NIGHT_SKY_GLSL
#define NEPHO_RENDER_NIGHT_SKY_GLSL
#include "render/night_sky_shared.h"

layout(scalar, set = 0, binding = NIGHT_SKY_BINDING) uniform NightSkyBlock { NightSkyUniform night_sky_data; } night_sky;
layout(scalar, set = 0, binding = NIGHT_SKY_BINDING + 1) readonly buffer SkyPixelBlock { uint values[]; } sky_pixels;

// Stars and the moon before them: all that stands behind the air but the sun. Multiply by the transmittance of the air.
vec3 night_bodies_luminance(FrameConstants f, ivec2 pixel) {
  uint at = 3u * night_sky.night_sky_data.pixel_stride * (uint(pixel.y) * f.size.x + uint(pixel.x));
  uvec3 word = uvec3(sky_pixels.values[at], sky_pixels.values[at + 1u], sky_pixels.values[at + 2u]);
  return sky_pixel_luminance(night_sky.night_sky_data, word, pixel_solid_angle_sr(f, vec2(pixel) + 0.5));
}

// Share of a pixel that the moon hides: the sun's disc in an eclipse.
float moon_cover(FrameConstants f, vec3 dir) { return moon_disc_cover(f, dir) * night_sky.night_sky_data.moon_present; }

// The same in two parts for background.comp, which adds them as moon + stars * (1 - cover): all is in the first.
vec3 moon_disc_luminance(FrameConstants f, vec3 dir) {
  vec2 pixel;
  pixel_from_direction(f, dir, pixel);
  return night_bodies_luminance(f, clamp(ivec2(pixel), ivec2(0), ivec2(f.size) - 1));
}
vec3 stars_luminance(FrameConstants f, ivec2 pixel) { return vec3(0); }

// The glowing layer 85 to 97 km up along a ray to space or, when hits_ground, to the ground. `transmittance` is the air's
// along the whole ray: what glows behind the ray's lowest point comes through it, what glows before does not.
vec3 airglow_luminance(FrameConstants f, vec3 dir, bool hits_ground, vec3 transmittance) {
  vec2 path = airglow_path_m(f.planet, dir, hits_ground) / (kAirglowTop_m - kAirglowBottom_m);
  return night_sky.night_sky_data.airglow * (path.x + path.y * transmittance);
}

// Light of airglow and stars on a horizontal plane at the ground, lux: the least light of any night.
vec3 night_illuminance_lux() { return night_sky.night_sky_data.night_illuminance; }
#endif
