// The air before any point that a camera within the air may see, as a small volume per light (docs/atmosphere.md, 'Air volume'):
// layout and mappings.
//
// Azimuth (as of sky views), row (elevation) and slice (distance). Rays that meet the floor, kAirFloor_m below the camera's sea, and
// those that leave the air have rows of their own, so that no texel straddles that edge; slices of both end where the ray does.
// Texels hold light and optical depth over what a column of the same length has with densities that are exponential between its two
// ends: slow functions, whose interpolation costs little.
#ifndef NEPHO_AIR_VOLUME_SHARED_H
#define NEPHO_AIR_VOLUME_SHARED_H
#include "atmosphere/atmosphere_shared.h"
SHARED_BEGIN

SHARED_CONST int kAirAzimuths = 24;
SHARED_CONST int kAirSkyRows = 36;
SHARED_CONST int kAirGroundRows = 28;
SHARED_CONST int kAirRows = 64;        // both
SHARED_CONST int kAirSlices = 32;
SHARED_CONST int kAirParts = 3;        // stacked in y: gas, aerosol, multiple scattering; with one channel of optical depth each
SHARED_CONST float kAirFloor_m = -300.0f;
SHARED_CONST float kAirNear_m = 8.0e3f;  // slices are even up to about here, then in proportion
SHARED_CONST float kAirFirst_m = 1.0f;   // of the first slice
SHARED_CONST float kLeastThrough = 1.0e-5f;  // transmittance that is told apart from less
// Tables of light at points: 4 stacked in y, see AirLight. Heights by their square root, 0 to table_top_m.
SHARED_CONST int kLightMu = 128;
SHARED_CONST int kLightHeights = 64;
SHARED_CONST int kLightTables = 4;       // transmittance to the key light; sky light by the sun, by the moon; moonlight beside the key light
SHARED_CONST float kLeastTabled = 1.0e-30f;

// For one light.
struct AirVolumeLight {
  vec3 forward;      // unit, scaled space, horizontal towards the light
  float mu_s;        // light's cosine to the geodetic normal at the camera
  vec3 side;         // up x forward
  float pad0;
  ivec4 window;      // azimuths and rows that the picture sees: first x, y and last x, y; rows of the ground count downwards from -1
};

struct AirVolumeData {
  vec3 up;           // unit, scaled space: the camera's vertical
  float h;           // the camera's scaled height, >= 0
  AirVolumeLight lights[2];
  vec3 gas_per_m;    // representative coefficients of the channels at height 0: what optical depths are stored over
  float dip_t;       // tan of half the dip of the floor's horizon
  vec3 aerosol_per_m;
  float table_top_m; // height of the light tables' last row
  vec3 mu_low;       // cosines of the light tables' first column: key light, sun, moon
  float pad1;
  vec3 mu_span;
  float pad0;
};

// A direction's place, from its components along forward, side and up (any length).
struct AirPlace {
  float azimuth;     // 0..1
  float row;         // 0..1 within its rows
  bool down;         // it meets the floor
  float mu;          // cosine to the vertical in scaled space
};

SHARED_FN AirPlace air_place(AirVolumeData volume, float c, float s, float up) {
  float level2 = c * c + s * s;
  float whole = sqrt(level2 + up * up);
  float t = up / (whole + sqrt(level2));  // tan(elevation / 2)
  AirPlace place;
  place.azimuth = 0.5f - 0.5f * c / max(abs(c) + abs(s), 1.0e-12f);
  place.down = t < -volume.dip_t;
  float off = place.down ? (-volume.dip_t - t) / (1.0f - volume.dip_t) : (t + volume.dip_t) / (1.0f + volume.dip_t);
  place.row = pow(clamp(off, 1.0e-12f, 1.0f), 1.0f / 3.0f);  // dense where rays graze the ground
  place.mu = clamp(up / whole, -1.0f, 1.0f);
  return place;
}

// And back: unit vector (forward, side, up).
SHARED_FN vec3 air_place_direction(AirVolumeData volume, float azimuth, float row, bool down) {
  float off = row * row * row;
  float t = down ? -volume.dip_t - off * (1.0f - volume.dip_t) : off * (1.0f + volume.dip_t) - volume.dip_t;
  float c = 1.0f - 2.0f * azimuth;
  float s = 1.0f - abs(c);
  float inv = (1.0f - t * t) / ((1.0f + t * t) * sqrt(c * c + s * s));
  return vec3(c * inv, s * inv, 2.0f * t / (1.0f + t * t));
}

// Scaled metres to where a ray ends: at the floor or at the top of the air.
SHARED_FN float air_end(AtmosphereUniform air, float h, float mu, bool down) {
  float r_mu = (air.radius_m + h) * mu;
  float gap2 = (h - kAirFloor_m) * (2.0f * air.radius_m + h + kAirFloor_m);
  float to_floor = gap2 / (sqrt(max(r_mu * r_mu - gap2, 0.0f)) - min(r_mu, -1.0f));
  return down ? to_floor : distance_to_top(air, h, mu);
}

// Slice, 0..1, of a distance, and back.
SHARED_FN float air_slice(float end_m, float length_m) {
  return clamp(log(1.0f + length_m / kAirNear_m) / log(1.0f + end_m / kAirNear_m), 0.0f, 1.0f);
}
SHARED_FN float air_slice_distance(float end_m, float slice) {
  return max(kAirNear_m * (exp(slice * log(1.0f + end_m / kAirNear_m)) - 1.0f), kAirFirst_m);
}

// Height at a distance along a ray, below 0 too.
SHARED_FN float air_height(AtmosphereUniform air, float h, float mu, float t) {
  return height_from_rho2(air, rho2_from_height(air, h) + t * (2.0f * (air.radius_m + h) * mu + t));
}

// Mean of exp(-h / scale) over heights between two.
SHARED_FN float mean_between(float h0, float h1, float scale_m) {
  float x = abs(h1 - h0) / scale_m;
  float mean = x < 1.0e-2f ? 1.0f - x * (0.5f - x / 6.0f) : (1.0f - exp(-x)) / x;
  return mean * exp(-min(h0, h1) / scale_m);
}
// Columns of gas and aerosol of a path whose heights rose evenly, m.
SHARED_FN vec2 even_columns(AtmosphereUniform air, float h0, float h1, float length_m) {
  return length_m * vec2(mean_between(h0, h1, air.rayleigh_scale_height_m), mean_between(h0, h1, air.mie_scale_height_m));
}

// (1 - exp(-depth)) / depth: share of the light of an even medium that its own depth leaves.
SHARED_FN vec3 open_share(vec3 depth, vec3 through) {
  vec3 few = vec3(1.0f) - 0.5f * depth;
  return vec3(depth.x < 1.0e-3f ? few.x : (1.0f - through.x) / depth.x, depth.y < 1.0e-3f ? few.y : (1.0f - through.y) / depth.y,
              depth.z < 1.0e-3f ? few.z : (1.0f - through.z) / depth.z);
}

// Place in the light tables: column and row, 0..1.
SHARED_FN float light_row(AirVolumeData volume, float height_m) { return sqrt(clamp(height_m / volume.table_top_m, 0.0f, 1.0f)); }
SHARED_FN float light_row_height(AirVolumeData volume, float row) { return row * row * volume.table_top_m; }

SHARED_END
#endif
