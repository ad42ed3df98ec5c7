// From scene-linear Rec. 709 luminance (cd/m2) to the 8-bit display (docs/exposure.md).
#ifndef NEPHO_COMMON_TONEMAP_H
#define NEPHO_COMMON_TONEMAP_H
#include "common/shared.h"
SHARED_BEGIN

SHARED_CONST uint kToneLinear = 0u;
SHARED_CONST uint kToneReinhard = 1u;
SHARED_CONST uint kToneAces = 2u;
SHARED_CONST uint kToneAgx = 3u;

SHARED_FN float luminance(vec3 rgb) { return dot(rgb, vec3(0.2126f, 0.7152f, 0.0722f)); }  // Rec. 709

// Scale from luminance to sensor units, 1 = saturation: 1 / (1.2 * 2^EV100), the saturation-based speed of ISO 12232
// with a lens transmission of 0.65 (Lagarde and de Rousiers 2014, eq. 4.3).
SHARED_FN float exposure_from_ev100(float ev100) { return 1.0f / (1.2f * exp2(ev100)); }

// EV100 that a reflected-light meter with K = 12.5 shows for this average luminance, cd/m2 (ISO 2720).
SHARED_FN float ev100_from_luminance(float luminance_cd_m2) { return log2(luminance_cd_m2 * 100.0f / 12.5f); }

// EV100 at which this luminance, cd/m2, becomes `level` of saturation: the inverse of exposure_from_ev100.
SHARED_FN float ev100_that_shows(float luminance_cd_m2, float level) { return log2(luminance_cd_m2 / (1.2f * level)); }

// Stops by which a photographer leaves a scene of this metered luminance, cd/m2, darker than by day: half of 4.5 at
// 0.01 cd/m2 (a landscape under the full moon), < 0.05 above 7 cd/m2. The shape is Naka and Rushton's response of the
// retina (docs/exposure.md, 'Night').
SHARED_FN float night_darkening_ev(float luminance_cd_m2) {
  return 4.5f / (1.0f + exp2(0.7f * log2(max(luminance_cd_m2, 1.0e-12f) / 0.01f)));
}

SHARED_FN float srgb_from_linear(float v) {
  return v <= 0.0031308f ? 12.92f * v : 1.055f * pow(v, 1.0f / 2.4f) - 0.055f;
}

// Colours outside of Rec. 709 have negative components. They move towards the grey of equal luminance Y, along a line of
// constant hue. With d = (Y - lowest) / Y, 0 for grey and 1 on the gamut's edge, d becomes f(d): d itself up to the knee
// k = 0.9, then, with slope 1 at k, towards 1: f = k + (1 - k) x / (1 + x), x = (d - k) / (1 - k), which is
// (d - k^2) / (d + 1 - 2 k). This is f(d) / d for d = distance / room.
SHARED_FN float gamut_shrink(float distance, float room) {
  const float k = 0.9f;
  float soft = room * (distance - k * k * room) / (distance * (distance + (1.0f - 2.0f * k) * room));
  return distance > k * room ? soft : 1.0f;
}

// Keeps Y, and leaves nothing negative: Y - lowest becomes Y f(d) < Y. What has Y <= 0 becomes black.
SHARED_FN vec3 compress_gamut(vec3 rgb) {
  float y = max(luminance(rgb), 0.0f);
  float shrink = gamut_shrink(y - min(rgb.r, min(rgb.g, rgb.b)), y);
  return max(vec3(y) + shrink * (rgb - y), vec3(0.0f));
}

// The same towards the display's white: with d = (highest - Y) / (1 - Y). Colours brighter than white become white.
SHARED_FN vec3 compress_highlights(vec3 rgb) {
  float y = luminance(rgb);
  float shrink = y < 1.0f ? gamut_shrink(max(rgb.r, max(rgb.g, rgb.b)) - y, 1.0f - y) : 0.0f;
  return vec3(y) + shrink * (rgb - y);
}

// Reinhard et al. 2002, eq. 4, with white at 4, on luminance.
SHARED_FN vec3 tone_reinhard(vec3 v) {
  float l = luminance(v);
  return v * ((1.0f + l / 16.0f) / (1.0f + l));
}

// Stephen Hill's fit of the ACES RRT and ODT (BakingLab, MIT), input in linear Rec. 709.
SHARED_FN vec3 tone_aces(vec3 v) {
  const mat3 in_from_709 = mat3(0.59719f, 0.07600f, 0.02840f, 0.35458f, 0.90834f, 0.13383f, 0.04823f, 0.01566f, 0.83777f);
  const mat3 r709_from_out =
      mat3(1.60475f, -0.10208f, -0.00327f, -0.53108f, 1.10813f, -0.07276f, -0.07367f, -0.00605f, 1.07602f);
  v = in_from_709 * v;
  vec3 a = v * (v + 0.0245786f) - 0.000090537f;
  vec3 b = v * (0.983729f * v + 0.4329510f) + 0.238081f;
  return r709_from_out * (a / b);
}

// AgX (Troy Sobotka) by Benjamin Wrensch's minimal fit (iolite-engine.com, 'Minimal AgX Implementation').
// First its log encoding, 0..1: 16.5 stops, middle grey 0.18 at 20/33.
SHARED_FN vec3 agx_log(vec3 v) {
  const mat3 agx = mat3(0.842479062253094f, 0.0423282422610123f, 0.0423756549057051f, 0.0784335999999992f, 0.878468636469772f,
                        0.0784336f, 0.0792237451477643f, 0.0791661274605434f, 0.879142973793104f);
  const float min_ev = -12.47393f;
  const float max_ev = 4.026069f;
  return (clamp(log2(max(agx * v, vec3(1.0e-10f))), vec3(min_ev), vec3(max_ev)) - min_ev) / (max_ev - min_ev);
}

// The contrast curve; middle grey becomes 0.49.
SHARED_FN vec3 agx_contrast(vec3 x) {
  vec3 x2 = x * x;
  vec3 x4 = x2 * x2;
  return 15.5f * x4 * x2 - 40.14f * x4 * x + 31.96f * x4 - 6.868f * x2 * x + 0.4298f * x2 + 0.1191f * x - 0.00232f;
}

// Our look: power 1.15, saturation 1.2. It gives back some of the contrast and colour of daylight.
SHARED_FN vec3 agx_look(vec3 x) {
  x = pow(max(x, vec3(0.0f)), vec3(1.15f));
  return mix(vec3(luminance(x)), x, 1.2f);
}

// Out of the curve's primaries, to the display's values at gamma 2.2.
SHARED_FN vec3 agx_display(vec3 x) {
  const mat3 agx_inverse =
      mat3(1.19687900512017f, -0.0528968517574562f, -0.0529716355144438f, -0.0980208811401368f, 1.15190312990417f,
           -0.0980434501171241f, -0.0990297440797205f, -0.0989611768448433f, 1.15107367264116f);
  return max(agx_inverse * x, vec3(0.0f));
}

SHARED_FN vec3 tone_agx(vec3 v) { return pow(agx_display(agx_look(agx_contrast(agx_log(v)))), vec3(2.2f)); }

// Display-linear 0..1 from exposed linear values.
SHARED_FN vec3 tone_map(vec3 v, uint curve) {
  v = compress_gamut(v);
  vec3 mapped = v;
  if (curve == kToneReinhard) mapped = compress_highlights(tone_reinhard(v));
  if (curve == kToneAces) mapped = tone_aces(v);
  if (curve == kToneAgx) mapped = tone_agx(v);
  return clamp(mapped, vec3(0.0f), vec3(1.0f));
}

// The rest is the same without pow(), which is slow on software devices. Minimax fits; errors in steps of 1/255.

// srgb_from_linear for 0..1: above the knee a polynomial of sqrt(v), within 0.04; 0 and 1 are exact.
SHARED_FN vec3 srgb_from_linear_fast(vec3 v) {
  vec3 x = sqrt(v);
  vec3 high = -0.89199194f * x + 3.26054608f;
  high = high * x - 4.83314567f;
  high = high * x + 3.81211301f;
  high = high * x - 1.87839208f;
  high = high * x + 1.57302408f;
  high = high * x - 0.04215354f;
  return mix(12.92f * v, min(high, vec3(1.0f)), greaterThan(v, vec3(0.0031308f)));
}

// srgb_from_linear(x^2.2) for 0..1, within 0.025.
SHARED_FN vec3 srgb_from_gamma22_fast(vec3 x) {
  vec3 low = x * x * (27.27004547f * x + 5.69049399f);
  vec3 high = 0.16969916f * x - 0.55995577f;
  high = high * x + 0.74807791f;
  high = high * x - 0.57259625f;
  high = high * x + 1.26334230f;
  high = high * x - 0.04856735f;
  return mix(low, high, greaterThan(x, vec3(0.07272128f)));
}

// agx_log, within 0.01 after the contrast curve: exponent and mantissa, log2 of the latter by a polynomial.
SHARED_FN vec3 agx_log_fast(vec3 v) {
  const mat3 agx = mat3(0.842479062253094f, 0.0423282422610123f, 0.0423756549057051f, 0.0784335999999992f, 0.878468636469772f,
                        0.0784336f, 0.0792237451477643f, 0.0791661274605434f, 0.879142973793104f);
  uvec3 bits = floatBitsToUint(clamp(agx * v, vec3(1.7578139e-4f), vec3(16.2917424f)));
  vec3 m = uintBitsToFloat((bits & 0x7fffffu) | 0x3f800000u);
  vec3 y = -0.00497761752f * m + 0.0393764661f;
  y = y * m - 0.129341512f;
  y = y * m + 0.2476596f;
  y = y * m - 7.0936913f;
  return 0.0606060643f * vec3(bits >> 23u) + y;
}

// pow(agx_contrast(x), 1.15), within 0.045.
SHARED_FN vec3 agx_contrast_look_fast(vec3 x) {
  vec3 y = -5.47022000f * x + 28.28404283f;
  y = y * x - 37.33593676f;
  y = y * x + 3.72035400f;
  y = y * x + 17.35243525f;
  y = y * x - 6.50298594f;
  y = y * x + 0.94811079f;
  y = y * x + 0.00290970f;
  return y * x - 0.00017146f;
}

// agx_display after agx_look's saturation, as one matrix.
SHARED_FN vec3 agx_saturated_display(vec3 x) {
  const mat3 m = mat3(1.39374210f, -0.10599814f, -0.10608845f, -0.26064051f, 1.23923730f, -0.26070052f, -0.13327321f,
                      -0.13319406f, 1.36684756f);
  return clamp(m * x, vec3(0.0f), vec3(1.0f));
}

// sRGB-encoded 0..1 from exposed linear values: srgb_from_linear(tone_map(v)) to 0.11 steps of 1/255.
SHARED_FN vec3 display_from_exposed(vec3 v, uint curve) {
  if (curve == kToneAgx)
    return srgb_from_gamma22_fast(agx_saturated_display(agx_contrast_look_fast(agx_log_fast(compress_gamut(v)))));
  return srgb_from_linear_fast(tone_map(v, curve));
}

// Dither. A uniform value 0..1 of a low-discrepancy pattern (Roberts's R2 sequence over the pixels, exact in 32-bit
// integers): any small neighbourhood holds all values evenly, so that their mean converges faster than that of random
// noise and no clumps show. `offset` shifts the pattern: by the seed, and by thirds for red and blue.
SHARED_FN float dither_pattern(uvec2 pixel, uint offset) {
  return float((pixel.x * 3242174889u + pixel.y * 2447445414u + offset) >> 8) * (1.0f / 16777216.0f);
}

// 0..255 as whole numbers from 0..1: plus triangular noise of +-1, then rounded: mean and variance of the error do not
// depend on the value, so no bands and no noise that comes and goes. Within half a step of black and of white the noise is
// uniform, +-1/2: also without bias, and nothing is clipped: black stays black.
SHARED_FN float quantise(float v, float pattern) {
  float s = 255.0f * v;
  float t = 2.0f * pattern - 1.0f;
  float triangular = 1.0f - sqrt(1.0f - abs(t));
  triangular = t < 0.0f ? -triangular : triangular;
  float noise = abs(s - 127.5f) > 127.0f ? 0.4999f * t : triangular;
  return floor(s + noise + 0.5f);
}

SHARED_END
#endif
