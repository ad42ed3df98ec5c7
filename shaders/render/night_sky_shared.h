// The night sky beyond and above the air: stars, moon, airglow (docs/night_sky.md). Pure functions, shared by shaders and
// their tests. Directions are unit, camera-relative, ECEF axes.
#ifndef NEPHO_RENDER_NIGHT_SKY_SHARED_H
#define NEPHO_RENDER_NIGHT_SKY_SHARED_H
#include "common/frame.h"
SHARED_BEGIN

// What does not change within a frame. Luminances and illuminances are linear Rec. 709 in cd/m^2 and lux.
struct NightSkyUniform {
  mat3 moon_from_ecef;         // selenographic axes: x mean sub-Earth point, z north pole
  vec3 sun_from_moon;          // unit, towards the sun from the moon's centre
  float lunar_lambert;         // share of Lommel-Seeliger's law in the moon's, 1 at full moon
  vec3 moon_luminance;         // of a point whose albedo * shading is 1
  float moon_mean;             // mean of albedo * shading over the disc
  vec3 earthshine_luminance;   // of a point whose albedo is 1, lit by the Earth
  float moon_mean_albedo;      // mean albedo over the disc
  vec3 airglow;                // luminance of the layer seen vertically from below
  float moon_present;          // 1, or 0 for a scene without a moon
  vec3 starlight;              // mean luminance of what is too faint to be drawn as a star
  float star_unit_lux;         // of the numbers in the star image
  vec3 night_illuminance;      // on a horizontal plane at the ground
  uint star_stride;            // 1, or 0 where no stars are drawn and the star image has one pixel
};

// A star as the GPU has it.
struct StarOnGpu {
  vec3 dir_icrs;
  float illuminance_lux;
  vec3 color;  // of luminance 1
  float pad0;
};

struct StarSplatPush {
  mat3 ecef_from_icrs;
  uint star_count;
  float units_per_lux;
};

// ---- Pixels

// Pixel coordinates (pixel centres at +0.5, the inverse of pixel_direction) of a direction; false behind the camera.
SHARED_FN bool pixel_from_direction(FrameConstants frame, vec3 dir, SHARED_OUT(vec2) pixel) {
  float z = dot(dir, frame.forward);
  float inv = 1.0f / max(z, 1.0e-6f);
  float x = dot(dir, frame.right) / dot(frame.right, frame.right) * inv;
  float y = dot(dir, frame.up) / dot(frame.up, frame.up) * inv;
  pixel = vec2((0.5f + 0.5f * x) * float(frame.size.x), (0.5f - 0.5f * y) * float(frame.size.y)) - frame.jitter_px;
  return z > 1.0e-4f;
}

// Solid angle of the pixel with its centre at `pixel`, sr: its area on the plane at distance 1, over the cube of the
// distance to it (square of the distance, and the cosine).
SHARED_FN float pixel_solid_angle_sr(FrameConstants frame, vec2 pixel) {
  float x = 2.0f * (pixel.x + frame.jitter_px.x) / float(frame.size.x) - 1.0f;
  float y = 1.0f - 2.0f * (pixel.y + frame.jitter_px.y) / float(frame.size.y);
  vec3 v = frame.forward + x * frame.right + y * frame.up;
  float area = 4.0f * length(frame.right) * length(frame.up) / (float(frame.size.x) * float(frame.size.y));
  float d2 = dot(v, v);
  return area / (d2 * sqrt(d2));
}

// ---- Stars

SHARED_CONST float kStarSigma_px = 0.65f;  // width of a star's image: narrow, and still without jumps as it moves
SHARED_CONST int kStarReach_px = 2;        // its image has 2 * 2 + 1 pixels per side

// One row's weights of a star's image, for pixel offsets -2..2 from the pixel that holds it; `at` is the star's place
// within that pixel, -0.5..0.5. They sum to 1.
SHARED_FN float star_weight(int offset, float at) {
  float sum = 0.0f;
  float own = 0.0f;
  for (int i = -kStarReach_px; i <= kStarReach_px; ++i) {
    float d = float(i) - at;
    float w = exp(-0.5f * d * d / (kStarSigma_px * kStarSigma_px));
    sum += w;
    own = i == offset ? w : own;
  }
  return own / sum;
}

// ---- Moon

// A moon of a smaller radius is drawn at this one, as much dimmer: its light then changes by 1.3 % at most with its place
// between pixels (7 % at 1 px).
SHARED_CONST float kMoonLeast_px = 1.5f;

// Radius that the disc is drawn with, rad.
SHARED_FN float moon_drawn_radius(FrameConstants frame) {
  return max(frame.moon_angular_radius_rad, kMoonLeast_px * frame.pixel_angle_rad);
}

// Share of the pixel in direction `dir` that the disc covers, its limb smoothed over one pixel.
SHARED_FN float moon_disc_cover(FrameConstants frame, vec3 dir) {
  float angle = 2.0f * asin(min(0.5f * length(dir - frame.moon_dir), 1.0f));
  return clamp((moon_drawn_radius(frame) - angle) / frame.pixel_angle_rad + 0.5f, 0.0f, 1.0f);
}

// What enlarging and smoothing adds to the disc's area, taken off again: the integral of the cover over the sky is
// pi (radius^2 + pixel^2 / 12).
SHARED_FN float moon_disc_dimming(FrameConstants frame) {
  float r = moon_drawn_radius(frame), w = frame.pixel_angle_rad, true_r = frame.moon_angular_radius_rad;
  return true_r * true_r / (r * r + w * w / 12.0f);
}

// Unit normal of the moon's surface at the point seen in direction `dir`, and the cosine `mu` of the angle between it and
// the direction to the camera. Points past the limb give the limb's. sin(emission angle) = sin(angle) / sin(radius); the
// normal is turned by that angle less the angle at the eye.
SHARED_FN vec3 moon_normal(FrameConstants frame, vec3 dir, SHARED_OUT(float) mu) {
  float r = moon_drawn_radius(frame);
  vec3 across = dir - frame.moon_dir * dot(dir, frame.moon_dir);
  float angle = length(across);
  float s = min(angle / r, 0.9995f);
  float c = sqrt(1.0f - s * s);
  mu = c;
  across = across * (s * r / max(angle, 1.0e-9f));  // on the disc
  return normalize(across * (1.0f / r - c) - frame.moon_dir * (c + s * s * r));
}

// Radiance factor of the moon's surface over its albedo: McEwen's lunar-Lambert law (Icarus 92, 1991), 1 everywhere at
// full moon. mu_0 and mu: cosines of incidence and emission.
SHARED_FN float lunar_shading(float mu_0, float mu, float lunar_lambert) {
  float m0 = max(mu_0, 0.0f);
  return lunar_lambert * 2.0f * m0 / (m0 + max(mu, 1.0e-4f)) + (1.0f - lunar_lambert) * m0;
}

// Share of Lommel-Seeliger's law by phase angle (McEwen 1991), 0 past its range.
SHARED_FN float lunar_lambert_share(float phase_angle_rad) {
  float a = phase_angle_rad * (180.0f / kPi);
  return clamp(1.0f + a * (-0.019f + a * (2.42e-4f - 1.46e-6f * a)), 0.0f, 1.0f);
}

// Texture coordinates of a selenographic direction on a map from 180 W to 180 E, 90 N to 90 S.
SHARED_FN vec2 moon_map_uv(vec3 body) {
  return vec2(atan(body.y, body.x) / (2.0f * kPi) + 0.5f, 0.5f - asin(clamp(body.z, -1.0f, 1.0f)) / kPi);
}

// ---- Airglow

SHARED_CONST float kAirglowBottom_m = 85.0e3f;  // the sheet of 557.7 nm, sodium and the continuum
SHARED_CONST float kAirglowTop_m = 97.0e3f;

// Colour of airglow, linear Rec. 709 of luminance 1. From typical rates of a quiet mid-latitude night (Roach and Gordon 1973):
// 557.7 nm 250 R, sodium 75 R, continuum 0.4 R per angstrom, that is 36, 8 and 56 % of the luminance. The lines alone are
// outside Rec. 709: (0.08, 1.39, -0.17) and (2.80, 0.58, -0.13); the continuum is (1.05, 1.00, 0.90).
SHARED_FN vec3 airglow_color() { return vec3(0.842f, 1.106f, 0.433f); }

// Lengths of a ray within the glowing layer, m: x before the ray's lowest point (nothing but thin air in between), y
// after it (behind the air, or 0 behind the ground).
SHARED_FN vec2 airglow_path_m(PlanetView planet, vec3 dir, bool hits_ground) {
  vec2 outer, inner;
  bool enters = intersect_shell(planet, dir, kAirglowTop_m, outer);
  bool crosses = intersect_shell(planet, dir, kAirglowBottom_m, inner);
  if (!enters) return vec2(0.0f, 0.0f);
  float lowest = max(0.5f * (outer.x + outer.y), 0.0f);
  outer = max(outer, vec2(0.0f, 0.0f));
  inner = crosses ? max(inner, vec2(0.0f, 0.0f)) : vec2(lowest, lowest);
  float before = max(min(inner.x, lowest) - outer.x, 0.0f);
  float after = max(outer.y - max(inner.y, lowest), 0.0f);
  return vec2(before, hits_ground ? 0.0f : after);
}

// ---- Light of the moonless night on the ground

// Illuminance of a horizontal plane under a glowing layer of vertical luminance 1 at 91 km: the integral of van Rhijn's
// 1 / sqrt(1 - k (1 - mu^2)) times mu over the sky, 2 pi (1 - sqrt(1 - k)) / k, k = (R / (R + h))^2.
SHARED_FN float airglow_illuminance_per_luminance() {
  const float k = (6371.0f / 6462.0f) * (6371.0f / 6462.0f);
  return 2.0f * kPi * (1.0f - sqrt(1.0f - k)) / k;
}

SHARED_CONST float kNightAirTransmits = 0.85f;             // share of the night sky's light that clear air lets down
SHARED_CONST float kStarlightLuminance_cd_m2 = 9.0e-5f;    // faint stars, Milky Way, zodiacal light: mean over the sky

// Light of airglow and, with stars, of all stars and zodiacal light on a horizontal plane at the ground, lux.
SHARED_FN vec3 night_sky_illuminance(float airglow_cd_m2, bool stars) {
  float starlight = stars ? kPi * kStarlightLuminance_cd_m2 : 0.0f;
  return kNightAirTransmits * (airglow_cd_m2 * airglow_illuminance_per_luminance() * airglow_color() + vec3(starlight));
}

SHARED_END
#endif
