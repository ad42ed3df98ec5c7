// From scene-linear Rec. 709 luminance (cd/m2) to display (docs/units_and_frames.md, 'Exposure').
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

SHARED_FN float srgb_from_linear(float v) {
  return v <= 0.0031308f ? 12.92f * v : 1.055f * pow(v, 1.0f / 2.4f) - 0.055f;
}

// Reinhard et al. 2002 with white point 4, on luminance.
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

// AgX (Troy Sobotka), the polynomial fit of Benjamin Wrensch, with a mild look (slope 1, power 1.15, saturation 1.2)
// that gives back some of the contrast and colour of daylight.
SHARED_FN vec3 tone_agx(vec3 v) {
  const mat3 agx = mat3(0.842479062253094f, 0.0423282422610123f, 0.0423756549057051f, 0.0784335999999992f, 0.878468636469772f,
                        0.0784336f, 0.0792237451477643f, 0.0791661274605434f, 0.879142973793104f);
  const mat3 agx_inverse =
      mat3(1.19687900512017f, -0.0528968517574562f, -0.0529716355144438f, -0.0980208811401368f, 1.15190312990417f,
           -0.0980434501171241f, -0.0990297440797205f, -0.0989611768448433f, 1.15107367264116f);
  const float min_ev = -12.47393f;
  const float max_ev = 4.026069f;
  v = agx * max(v, vec3(0.0f));
  v = (clamp(log2(max(v, vec3(1.0e-10f))), vec3(min_ev), vec3(max_ev)) - min_ev) / (max_ev - min_ev);
  vec3 v2 = v * v;
  vec3 v4 = v2 * v2;
  v = 15.5f * v4 * v2 - 40.14f * v4 * v + 31.96f * v4 - 6.868f * v2 * v + 0.4298f * v2 + 0.1191f * v - 0.00232f;
  v = pow(max(v, vec3(0.0f)), vec3(1.15f));
  v = mix(vec3(luminance(v)), v, 1.2f);
  v = agx_inverse * v;
  return pow(max(v, vec3(0.0f)), vec3(2.2f));  // to display-linear
}

// Display-linear 0..1 from exposed linear values.
SHARED_FN vec3 tone_map(vec3 v, uint curve) {
  vec3 mapped = v;
  if (curve == kToneReinhard) mapped = tone_reinhard(v);
  if (curve == kToneAces) mapped = tone_aces(v);
  if (curve == kToneAgx) mapped = tone_agx(v);
  return clamp(mapped, vec3(0.0f), vec3(1.0f));
}

SHARED_END
#endif
