// Clear air around a sphere of radius R (in scaled space the ellipsoid is one, common/planet.h): parameters, geometry
// in heights, densities, table layouts. Derivations: docs/atmosphere.md.
//
// h is the height above the sphere, never the radius: rho^2 = r^2 - R^2 = h (2R + h) keeps its precision in float.
// mu, mu_s are the cosines of the view's and the sun's zenith angles, nu that of the angle between them.
#ifndef NEPHO_ATMOSPHERE_SHARED_H
#define NEPHO_ATMOSPHERE_SHARED_H
#include "common/shared.h"
SHARED_BEGIN

// Table sizes in texels.
SHARED_CONST int kColumnMu = 256;
SHARED_CONST int kColumnR = 96;
SHARED_CONST int kAirR = 32;        // heights of all other tables
SHARED_CONST int kAirMuS = 32;      // sun zenith cosines
SHARED_CONST int kAirNu = 8;        // view-sun angles
SHARED_CONST int kSourceMu = 32;    // view zenith cosines of the source function, all directions
SHARED_CONST int kMirrorMu = 48;    // elevations of the sky seen from the sea
SHARED_CONST int kIrradianceParts = 3;  // stacked in v: horizontal irradiance, mean radiance above, below
SHARED_CONST int kSkyAzimuths = 24;     // of a sky view, sun's azimuth to the one opposite
SHARED_CONST int kSkyRows = 112;        // horizon to zenith
SHARED_CONST int kSkyParts = 3;         // stacked: without aerosol, single scattering by aerosol, transmittance
SHARED_CONST int kSkyViewsWide = 64;    // sky views side by side in their image; more go below
// The spectrum: wavelengths in threes, a vec3 each. One group is 680, 550, 440 nm.
SHARED_CONST int kMaxSpectralGroups = 5;
// Light in logarithmic tables is never less than this, per unit of the sun's.
SHARED_CONST float kLeastLight = 1.0e-14f;

// Directions of the incident light that is scattered again: zenith angles in three panels, split at the horizon of the
// planet and at the horizontal, times azimuths from the sun in [0, pi]; the light is symmetric about the sun's
// vertical.
SHARED_CONST int kIncidentGround = 8;
SHARED_CONST int kIncidentBand = 4;
SHARED_CONST int kIncidentSky = 12;
SHARED_CONST int kIncidentMu = 24;
SHARED_CONST int kIncidentPhi = 16;
SHARED_CONST int kIncidentDirections = 384;

// Gauss-Legendre abscissae and weights on [0, 1].
SHARED_CONST float kGauss4X[4] = {0.069431844f, 0.330009478f, 0.669990522f, 0.930568156f};
SHARED_CONST float kGauss4W[4] = {0.173927423f, 0.326072577f, 0.326072577f, 0.173927423f};
SHARED_CONST float kGauss8X[8] = {0.019855072f, 0.101666761f, 0.237233795f, 0.408282679f,
                                  0.591717321f, 0.762766205f, 0.898333239f, 0.980144928f};
SHARED_CONST float kGauss8W[8] = {0.050614268f, 0.111190517f, 0.156853323f, 0.181341892f,
                                  0.181341892f, 0.156853323f, 0.111190517f, 0.050614268f};
SHARED_CONST float kGauss12X[12] = {0.009219683f, 0.047941372f, 0.115048663f, 0.206341023f, 0.316084251f, 0.437383296f,
                                    0.562616704f, 0.683915749f, 0.793658977f, 0.884951337f, 0.952058628f, 0.990780317f};
SHARED_CONST float kGauss12W[12] = {0.023587668f, 0.053469663f, 0.080039164f, 0.101583713f, 0.116746268f, 0.124573523f,
                                    0.124573523f, 0.116746268f, 0.101583713f, 0.080039164f, 0.053469663f, 0.023587668f};

struct AtmosphereUniform {
  float radius_m;                // of the sphere in scaled space
  float top_m;                   // height of the top of the air
  float rho_top_m;               // horizontal distance from the ground to the top, sqrt(top (2R + top))
  float sun_angular_radius_rad;  // seen from 1 au
  float rayleigh_scale_height_m;
  float mie_scale_height_m;
  float ozone_center_m;
  float ozone_half_width_m;
  float mie_g;                   // the aerosol's phase function: phase_k (1 + phase_b cos^2) / (1 + g^2 - 2 g cos)^1.5
  float mie_phase_k;
  float mie_phase_b;             // 1 Cornette-Shanks, 0 Henyey-Greenstein
  float ground_albedo;
  float mu_s_scale;              // A of the mu_s mapping, from the lowest sun
  float min_mu_s;                // cosine of the lowest sun of the tables
  float sky_view_top_m;          // cameras up to this scaled height have sky views
  vec3 luminance_factor;         // from what the lookups sum to, to linear Rec. 709 in cd/m^2 (1 with the full spectrum)
  vec3 sun_illuminance;          // at 1 au on a facing plane, lux per channel
};

// Three wavelengths.
struct SpectralGroup {
  vec3 rayleigh_scattering_per_m;  // at height 0
  vec3 mie_scattering_per_m;
  vec3 mie_extinction_per_m;
  vec3 ozone_absorption_per_m;     // at the tent's top
  vec3 solar_irradiance;           // at 1 au, W m^-2 nm^-1
  mat3 rgb;                        // columns: radiance at each wavelength to linear Rec. 709; identity with one group
  mat3 sun_share;                  // columns: share of each wavelength in the three channels of unscattered sunlight
  mat4x3 basis;                    // log(J / E) of the wavelengths from the four coefficients of the logarithmic tables
  mat3x4 fit;                      // its part of the coefficients from log(J / E)
};

// The uniform block `atmosphere`.
struct AtmosphereData {
  AtmosphereUniform air;
  SpectralGroup spectrum[kMaxSpectralGroups];
};

// --- distances ---------------------------------------------------------------------------------------------------

SHARED_FN float rho2_from_height(AtmosphereUniform air, float h) { return h * (2.0f * air.radius_m + h); }
SHARED_FN float height_from_rho2(AtmosphereUniform air, float rho2) {
  return rho2 / (air.radius_m + sqrt(max(air.radius_m * air.radius_m + rho2, 0.0f)));
}

// r_top^2 - r^2, without cancellation.
SHARED_FN float gap2_to_top(AtmosphereUniform air, float h) {
  return max(air.top_m - h, 0.0f) * (2.0f * air.radius_m + air.top_m + h);
}

// Along a ray that starts at 0 <= h <= top. The larger root of t^2 + 2 r mu t = r_top^2 - r^2.
SHARED_FN float distance_to_top(AtmosphereUniform air, float h, float mu) {
  float r_mu = (air.radius_m + h) * mu;
  float gap2 = gap2_to_top(air, h);
  float root = sqrt(r_mu * r_mu + gap2);
  return r_mu > 0.0f ? gap2 / (r_mu + root) : root - r_mu;
}

// Along a ray that hits the ground; 0 for one that cannot. The smaller root of t^2 + 2 r mu t = -rho^2.
SHARED_FN float distance_to_ground(AtmosphereUniform air, float h, float mu) {
  float r_mu = (air.radius_m + h) * mu;
  float rho2 = rho2_from_height(air, h);
  float root = sqrt(max(r_mu * r_mu - rho2, 0.0f));
  return r_mu < 0.0f ? rho2 / (root - r_mu) : 0.0f;
}

// Cosine of the zenith angle of the geometric horizon, <= 0.
SHARED_FN float horizon_mu(AtmosphereUniform air, float h) {
  return -sqrt(max(rho2_from_height(air, h), 0.0f)) / (air.radius_m + h);
}

// For code that knows nothing better (precomputation). Near the horizon the caller's geometry decides, not this.
SHARED_FN bool hits_ground_from(AtmosphereUniform air, float h, float mu) {
  float r_mu = (air.radius_m + h) * mu;
  return mu < 0.0f && r_mu * r_mu >= rho2_from_height(air, h);
}

// Height at a distance t along a ray.
SHARED_FN float height_along(AtmosphereUniform air, float h, float mu, float t) {
  float rho2 = rho2_from_height(air, h) + t * (2.0f * (air.radius_m + h) * mu + t);
  return clamp(height_from_rho2(air, rho2), 0.0f, air.top_m);
}

// --- matter ------------------------------------------------------------------------------------------------------

SHARED_FN float rayleigh_density(AtmosphereUniform air, float h) { return exp(-h / air.rayleigh_scale_height_m); }
SHARED_FN float mie_density(AtmosphereUniform air, float h) { return exp(-h / air.mie_scale_height_m); }
SHARED_FN float ozone_density(AtmosphereUniform air, float h) {
  return max(0.0f, 1.0f - abs(h - air.ozone_center_m) / air.ozone_half_width_m);
}

// Of gas, aerosol, ozone.
SHARED_FN vec3 densities(AtmosphereUniform air, float h) {
  return vec3(rayleigh_density(air, h), mie_density(air, h), ozone_density(air, h));
}

// Optical depth at three wavelengths from the columns of the three species (density integrated along a path, m); with
// densities instead of columns: extinction, 1/m.
SHARED_FN vec3 optical_depth(SpectralGroup group, vec3 columns) {
  return columns.x * group.rayleigh_scattering_per_m + columns.y * group.mie_extinction_per_m +
         columns.z * group.ozone_absorption_per_m;
}

// Phase function of the aerosol, 1/sr.
SHARED_FN float phase_aerosol(AtmosphereUniform air, float nu) {
  float d = max(1.0f + air.mie_g * air.mie_g - 2.0f * air.mie_g * nu, 1.0e-7f);
  return air.mie_phase_k * (1.0f + air.mie_phase_b * nu * nu) / (d * sqrt(d));
}

// Share of the sun's disc above the planet's horizon, seen from height h (Bruneton 2017, GetTransmittanceToSun).
SHARED_FN float sun_visibility(AtmosphereUniform air, float h, float mu_s) {
  float r = air.radius_m + max(h, 0.0f);
  float sin_h = air.radius_m / r;
  float x = (mu_s - horizon_mu(air, max(h, 0.0f))) / (sin_h * air.sun_angular_radius_rad);
  float s = clamp(0.5f * (x + 1.0f), 0.0f, 1.0f);
  return s * s * (3.0f - 2.0f * s);
}

// Mean over the sun's disc of the cosine to the vertical, >= 0 (Bruneton 2017, ComputeDirectIrradiance).
SHARED_FN float mean_sun_cosine(AtmosphereUniform air, float mu_s) {
  float alpha = air.sun_angular_radius_rad;
  if (mu_s < -alpha) return 0.0f;
  return mu_s > alpha ? mu_s : (mu_s + alpha) * (mu_s + alpha) / (4.0f * alpha);
}

// --- quadrature along a path --------------------------------------------------------------------------------------

// A path is cut into panels where its integrand has corners: at its lowest point, where it enters and leaves the
// planet's shadow, and where the sunlight that reaches it ends (shadow_m: of clouds). In each, with s in [0, 1] from
// its lower end, t = L (0.4 s + 0.6 s^2) and Gauss-Legendre in s: nodes gather where the air is dense, which a vertical
// path needs, without starving a grazing one (docs/atmosphere.md compares maps and node counts).
SHARED_CONST float kLongPath_m = 2.0e5f;
struct PathPanels {
  vec4 cut_m;    // ascending distances from the start; those beyond the end are the end
  float low_m;   // of the lowest point
  float end_m;
  int count;
};

SHARED_FN PathPanels path_panels(AtmosphereUniform air, float h, float mu, float mu_s, float nu, float length_m,
                                 float sunlit_m) {
  float r = air.radius_m + h;
  PathPanels p;
  p.end_m = length_m;
  p.low_m = clamp(-r * mu, 0.0f, length_m);
  // The shadow is a half cylinder: |p|^2 - (p.s)^2 = R^2 behind the planet, p = start + t dir.
  float a = max(1.0f - nu * nu, 1.0e-9f);
  float b = r * (mu - mu_s * nu);
  float c = rho2_from_height(air, h) - (r * mu_s) * (r * mu_s);
  float root = sqrt(max(b * b - a * c, 0.0f));
  float q = b > 0.0f ? -(b + root) : root - b;
  float t0 = q / a;
  float t1 = q != 0.0f ? c / q : 0.0f;
  bool crosses = b * b > a * c;
  t0 = crosses && r * mu_s + t0 * nu < 0.0f ? clamp(t0, 0.0f, length_m) : length_m;
  t1 = crosses && r * mu_s + t1 * nu < 0.0f ? clamp(t1, 0.0f, length_m) : length_m;
  // A long path without an end of sunlight is cut far behind its lowest point: eight nodes are few for a horizontal one.
  float l0 = p.low_m > 0.0f ? p.low_m : length_m;
  float l1 = min(sunlit_m < length_m ? sunlit_m : p.low_m + kLongPath_m, length_m);
  float s0 = min(t0, t1), s1 = max(t0, t1);
  // Four numbers in order.
  float a0 = min(s0, l0), a1 = max(s0, l0), b0 = min(s1, l1), b1 = max(s1, l1);
  float m0 = max(a0, b0), m1 = min(a1, b1);
  p.cut_m = vec4(min(a0, b0), min(m0, m1), max(m0, m1), max(a1, b1));
  // A panel shorter than this holds nothing; the cut at its start then only costs time.
  float least = 1.0e-4f * length_m;
  p.cut_m = vec4(p.cut_m.x > least ? p.cut_m.x : length_m, p.cut_m.y > least ? p.cut_m.y : length_m,
                 p.cut_m.z > least ? p.cut_m.z : length_m, p.cut_m.w > least ? p.cut_m.w : length_m);
  a0 = min(p.cut_m.x, p.cut_m.y);
  a1 = max(p.cut_m.x, p.cut_m.y);
  b0 = min(p.cut_m.z, p.cut_m.w);
  b1 = max(p.cut_m.z, p.cut_m.w);
  m0 = max(a0, b0);
  m1 = min(a1, b1);
  p.cut_m = vec4(min(a0, b0), min(m0, m1), max(m0, m1), max(a1, b1));
  float most = length_m - least;
  p.count = length_m > 0.0f ? 1 + int(p.cut_m.x < most) + int(p.cut_m.y < most) + int(p.cut_m.z < most) + int(p.cut_m.w < most) : 0;
  return p;
}

// Distance from the ray's start (x) and weight in m (y) of the node with abscissa x and weight w on [0, 1], which
// counts from the panel's lower end.
SHARED_FN vec2 path_node(PathPanels p, int panel, float x, float w) {
  float from = panel == 0 ? 0.0f : panel == 1 ? p.cut_m.x : panel == 2 ? p.cut_m.y : panel == 3 ? p.cut_m.z : p.cut_m.w;
  float to = panel + 1 >= p.count ? p.end_m : panel == 0 ? p.cut_m.x : panel == 1 ? p.cut_m.y : panel == 2 ? p.cut_m.z : p.cut_m.w;
  float length_m = to - from;
  float t = length_m * x * (0.4f + 0.6f * x);
  bool descending = 0.5f * (from + to) < p.low_m;
  return vec2(descending ? to - t : from + t, length_m * w * (0.4f + 1.2f * x));
}

// Columns of the three species (m of air as dense as at height 0, at the tent's top) from height h to the top along a
// ray that does not hit the ground: 8 pieces of 8 nodes on either side of its lowest point, because ozone's tent has
// corners.
SHARED_FN vec3 columns_to_top(AtmosphereUniform air, float h, float mu) {
  vec3 sum = vec3(0.0f);
  float length_m = distance_to_top(air, h, mu);
  PathPanels p;
  p.end_m = length_m;
  p.low_m = clamp(-(air.radius_m + h) * mu, 0.0f, length_m);
  p.cut_m = vec4(p.low_m > 0.0f ? p.low_m : length_m, length_m, length_m, length_m);
  p.count = p.low_m > 0.0f ? 2 : 1;
  for (int panel = 0; panel < p.count; ++panel) {
    for (int i = 0; i < 64; ++i) {
      float x = (float(i >> 3) + kGauss8X[i & 7]) / 8.0f;
      vec2 node = path_node(p, panel, x, kGauss8W[i & 7] / 8.0f);
      sum += node.y * densities(air, height_along(air, h, mu, node.x));
    }
  }
  return sum;
}

// --- table coordinates --------------------------------------------------------------------------------------------

// Texture coordinate whose ends fall on the centres of the first and last texel, and back.
SHARED_FN float texel_coord(float x, int size) { return (0.5f + x * float(size - 1)) / float(size); }
SHARED_FN float unit_from_texel(int i, int size) { return float(i) / float(size - 1); }

// Heights: u = rho / rho_top, dense near the ground.
SHARED_FN float unit_from_height(AtmosphereUniform air, float h) {
  return clamp(sqrt(max(rho2_from_height(air, h), 0.0f)) / air.rho_top_m, 0.0f, 1.0f);
}
SHARED_FN float height_from_unit(AtmosphereUniform air, float u) {
  float rho = u * air.rho_top_m;
  return u >= 1.0f ? air.top_m : height_from_rho2(air, rho * rho);
}

// View directions that reach space: u runs over the distance to the top, from straight up to the horizon.
SHARED_FN float unit_from_sky_mu(AtmosphereUniform air, float h, float mu) {
  float d_min = air.top_m - h;
  float d_max = sqrt(max(rho2_from_height(air, h), 0.0f)) + air.rho_top_m;
  return clamp((distance_to_top(air, h, mu) - d_min) / (d_max - d_min), 0.0f, 1.0f);
}
SHARED_FN float sky_mu_from_unit(AtmosphereUniform air, float h, float u) {
  float d_min = air.top_m - h;
  float d_max = sqrt(max(rho2_from_height(air, h), 0.0f)) + air.rho_top_m;
  float d = d_min + u * (d_max - d_min);
  if (d <= 0.0f) return 1.0f;
  return clamp((gap2_to_top(air, h) - d * d) / (2.0f * (air.radius_m + h) * d), -1.0f, 1.0f);
}

// Sun directions, by the distance to the top seen from the ground (Bruneton 2017): dense where the sun is low. Then
// u' = (sqrt(1 + 8 u) - 1) / 2, which gives half of the texels to the sun below the horizon: light falls steeply there.
SHARED_FN float unit_from_mu_s(AtmosphereUniform air, float mu_s) {
  float a = (distance_to_top(air, 0.0f, mu_s) - air.top_m) / (air.rho_top_m - air.top_m);
  float u = clamp((1.0f - a / air.mu_s_scale) / (1.0f + a), 0.0f, 1.0f);
  return 0.5f * (sqrt(1.0f + 8.0f * u) - 1.0f);
}
SHARED_FN float mu_s_from_unit(AtmosphereUniform air, float unit) {
  float u = 0.5f * unit * (1.0f + unit);
  float a = (air.mu_s_scale - u * air.mu_s_scale) / (1.0f + u * air.mu_s_scale);
  float d = air.top_m + min(a, air.mu_s_scale) * (air.rho_top_m - air.top_m);
  return clamp((air.rho_top_m * air.rho_top_m - d * d) / (2.0f * air.radius_m * d), -1.0f, 1.0f);
}
// A of that mapping: its value of `a` at the lowest sun.
SHARED_FN float mu_s_scale_for(AtmosphereUniform air, float min_mu_s) {
  return (distance_to_top(air, 0.0f, min_mu_s) - air.top_m) / (air.rho_top_m - air.top_m);
}

// Multiply scattered light below the lowest sun of the tables, as a share of that there: it goes on falling, tenfold in
// 2.3 degrees, about as it does in nature between 12 and 18 degrees.
SHARED_FN float night_fade(AtmosphereUniform air, float mu_s) { return exp(60.0f * min(mu_s - air.min_mu_s, 0.0f)); }

// View-sun angles theta: u = sin(theta / 2), even in angle towards the sun, where aerosol light changes fastest.
SHARED_FN float unit_from_nu(float nu) { return sqrt(clamp(0.5f * (1.0f - nu), 0.0f, 1.0f)); }
SHARED_FN float nu_from_unit(float u) { return 1.0f - 2.0f * u * u; }

// nu within what mu and mu_s allow.
SHARED_FN float possible_nu(float mu, float mu_s, float nu) {
  float s = sqrt(max((1.0f - mu * mu) * (1.0f - mu_s * mu_s), 0.0f));
  return clamp(nu, mu * mu_s - s, mu * mu_s + s);
}

// Zenith cosine and weight (of d mu) of incident direction i in [0, kIncidentMu).
SHARED_FN vec2 incident_mu(AtmosphereUniform air, float h, int i) {
  float m = horizon_mu(air, h);
  if (i < kIncidentGround) return vec2(-1.0f + kGauss8X[i] * (m + 1.0f), kGauss8W[i] * (m + 1.0f));
  int j = i - kIncidentGround;
  if (j < kIncidentBand) return vec2(m * (1.0f - kGauss4X[j]), -m * kGauss4W[j]);
  j -= kIncidentBand;
  return vec2(kGauss12X[j], kGauss12W[j]);
}
SHARED_FN float incident_phi(int i) { return (float(i) + 0.5f) * (kPi / float(kIncidentPhi)); }

// Unit vector with zenith cosine mu at azimuth phi from the sun; the sun is at azimuth 0, z is up.
SHARED_FN vec3 local_direction(float mu, float phi) {
  float s = sqrt(max(1.0f - mu * mu, 0.0f));
  return vec3(s * cos(phi), s * sin(phi), mu);
}

// --- the sky seen from one place -----------------------------------------------------------------------------------

// One camera within the air and one light. Axes in scaled space: elevation is measured from the sphere's own vertical,
// so that the horizon is as deep everywhere; azimuth from the light. The other half of the azimuths is the mirror image
// (to 1e-4; the aerosol's phase function is the pixel's).
struct SkyView {
  vec3 up;          // unit, scaled space
  float h;          // scaled height
  vec3 forward;     // unit, scaled space, towards the light's azimuth
  float horizon_t;  // tan of half the dip of the horizon, >= 0
  vec3 side;        // up x forward
  float mu_s;       // light's cosine to the geodetic normal
  vec3 light_dir;   // unit, true space
  float a_over_b;
  float split;      // share of rows below the horizontal
  vec2 uv_origin;   // of its first texel's centre in the image of all views
  vec2 uv_span;     // to its last texel's centre
  float part_v;     // from one of the three parts to the next: without aerosol, aerosol, transmittance
};

SHARED_FN float sky_view_split(float dip_rad) { return 0.45f * dip_rad / (dip_rad + 0.06f); }

// A direction's place in a sky view, 0..1 each, from its components along forward, side and up (any length). No function
// dearer than a square root: every pixel of a sky comes here.
//   azimuth: the 'diamond angle' 1/2 - c / (2 (|c| + |s|)), within 8 % of even in the angle;
//   row: with t = tan(elevation / 2), the share `split` of the rows below the horizontal as sqrt of the way up from the
//   horizon, so that tangent heights near the ground are dense, the others as sqrt(t).
SHARED_FN vec2 sky_view_unit(SkyView view, float c, float s, float up) {
  float level2 = c * c + s * s;
  float t = up / (sqrt(level2 + up * up) + sqrt(level2));
  float azimuth = 0.5f - 0.5f * c / max(abs(c) + abs(s), 1.0e-12f);
  float low = sqrt(clamp((t + view.horizon_t) / max(view.horizon_t, 1.0e-7f), 0.0f, 1.0f));
  float high = sqrt(clamp(t, 0.0f, 1.0f));
  return vec2(azimuth, view.split * low + (1.0f - view.split) * high);
}
// And back: unit vector (forward, side, up).
SHARED_FN vec3 sky_view_direction(SkyView view, vec2 unit) {
  float low = clamp(unit.y / max(view.split, 1.0e-6f), 0.0f, 1.0f);
  float high = clamp((unit.y - view.split) / (1.0f - view.split), 0.0f, 1.0f);
  float t = view.horizon_t * (low * low - 1.0f) + high * high;
  float c = 1.0f - 2.0f * unit.x;
  float s = 1.0f - abs(c);
  float inv = (1.0f - t * t) / ((1.0f + t * t) * sqrt(c * c + s * s));
  return vec3(c * inv, s * inv, 2.0f * t / (1.0f + t * t));
}

SHARED_END
#endif
