#ifndef NEPHO_COMMON_GAMUT_H
#define NEPHO_COMMON_GAMUT_H
#include "common/shared.h"
SHARED_BEGIN

// Linear Rec. 709 without negative components. Light of few wavelengths (the red of a low sun, the violet rim of the air) is
// more saturated than the three primaries can show: one component is negative. Such a colour moves towards the grey of its
// luminance Y just as far as it must, c' = Y + (c - Y) Y / (Y - lowest), which keeps Y. Colours within stay as they are.
SHARED_FN vec3 within_rec709(vec3 c) {
  float y = max(0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z, 0.0f);
  float lowest = min(c.x, min(c.y, c.z));
  if (lowest >= 0.0f) return c;
  return max(vec3(y) + (c - vec3(y)) * (y / max(y - lowest, 1.0e-30f)), vec3(0.0f));
}

SHARED_END
#endif
