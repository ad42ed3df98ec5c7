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
SHARED_CONST int kTransmittanceMu = 256;  // transmittance_tex holds optical depths: they interpolate better
SHARED_CONST int kTransmittanceR = 64;
SHARED_CONST int kAirR = 32;          // heights of all other tables
SHARED_CONST int kAirMuS = 32;        // sun zenith cosines
SHARED_CONST int kAirNu = 8;          // view-sun angles
SHARED_CONST int kSkyMu = 64;         // view zenith cosines of rays that reach space: rayleigh, mie, multiple
SHARED_CONST int kSourceMu = 32;      // view zenith cosines of the source function, all directions
SHARED_CONST int kMultipleRows = 96;  // of multiple_tex: kSkyMu of radiance, then kSourceMu of the source function
SHARED_CONST int kIrradianceParts =
    3;  // of irradiance_tex, stacked in v: horizontal irradiance, mean radiance above, below
// The half-float tables hold values times this, so that twilight stays clear of half-float's denormals.
SHARED_CONST float kTableScale = 1024.0f;

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
  vec3 rayleigh_scattering_per_m;
  float rayleigh_scale_height_m;
  vec3 mie_scattering_per_m;
  float mie_scale_height_m;
  vec3 mie_extinction_per_m;
  float mie_g;
  vec3 ozone_absorption_per_m;
  float ozone_center_m;
  vec3 solar_irradiance;  // at 1 au, W m^-2 nm^-1
  float ozone_half_width_m;
  vec3 sky_luminance_factor;  // spectral radiance of the sky to linear Rec. 709 in cd/m^2 (luminance.h)
  float ground_albedo;
  vec3 sun_luminance_factor;  // the same for unscattered sunlight
  float mu_s_scale;           // A of the mu_s mapping, from the lowest sun
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

// Extinction from the three densities, 1/m.
SHARED_FN vec3 extinction_per_m(AtmosphereUniform air, vec3 density) {
  return density.x * air.rayleigh_scattering_per_m + density.y * air.mie_extinction_per_m +
         density.z * air.ozone_absorption_per_m;
}
SHARED_FN vec3 densities(AtmosphereUniform air, float h) {
  return vec3(rayleigh_density(air, h), mie_density(air, h), ozone_density(air, h));
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

// A path is cut at its lowest point into a descending and an ascending part. On each, with s in [0, 1] from its low
// end, t = L (0.4 s + 0.6 s^2), and Gauss-Legendre in s. Nodes gather where the air is dense, which a vertical path
// needs, without starving a grazing one (docs/atmosphere.md compares maps and node counts).
struct PathPart {
  float start_m;     // along the ray
  float length_m;    // 0: nothing to do
  float descending;  // 1 or 0
};

// part 0: descending, part 1: ascending, of a path of length_m from height h.
SHARED_FN PathPart path_part(AtmosphereUniform air, float h, float mu, float length_m, int part) {
  float low = clamp(-(air.radius_m + h) * mu, 0.0f, length_m);
  PathPart p;
  p.descending = part == 0 ? 1.0f : 0.0f;
  p.start_m = part == 0 ? 0.0f : low;
  p.length_m = part == 0 ? low : length_m - low;
  return p;
}

// Distance from the ray's start (x) and weight in m (y) of the node with abscissa x and weight w on [0, 1], which
// counts in the order of travel.
SHARED_FN vec2 path_node(PathPart part, float x, float w) {
  float s = part.descending > 0.5f ? 1.0f - x : x;
  float t = part.length_m * s * (0.4f + 0.6f * s);
  return vec2(part.start_m + (part.descending > 0.5f ? part.length_m - t : t), part.length_m * w * (0.4f + 1.2f * s));
}

// Optical depth from height h to the top along a ray that does not hit the ground: 8 panels of 8 nodes on each part,
// because ozone's tent has kinks.
SHARED_FN vec3 optical_depth_to_top(AtmosphereUniform air, float h, float mu) {
  vec3 sum = vec3(0.0f);
  float length_m = distance_to_top(air, h, mu);
  for (int part = 0; part < 2; ++part) {
    PathPart p = path_part(air, h, mu, length_m, part);
    if (p.length_m <= 0.0f) continue;
    for (int i = 0; i < 64; ++i) {
      float x = (float(i >> 3) + kGauss8X[i & 7]) / 8.0f;
      vec2 node = path_node(p, x, kGauss8W[i & 7] / 8.0f);
      sum += node.y * extinction_per_m(air, densities(air, height_along(air, h, mu, node.x)));
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

// Sun directions, by the distance to the top seen from the ground (Bruneton 2017): dense where the sun is low.
SHARED_FN float unit_from_mu_s(AtmosphereUniform air, float mu_s) {
  float a = (distance_to_top(air, 0.0f, mu_s) - air.top_m) / (air.rho_top_m - air.top_m);
  return clamp((1.0f - a / air.mu_s_scale) / (1.0f + a), 0.0f, 1.0f);
}
SHARED_FN float mu_s_from_unit(AtmosphereUniform air, float u) {
  float a = (air.mu_s_scale - u * air.mu_s_scale) / (1.0f + u * air.mu_s_scale);
  float d = air.top_m + min(a, air.mu_s_scale) * (air.rho_top_m - air.top_m);
  return clamp((air.rho_top_m * air.rho_top_m - d * d) / (2.0f * air.radius_m * d), -1.0f, 1.0f);
}
// A of that mapping: its value of `a` at the lowest sun.
SHARED_FN float mu_s_scale_for(AtmosphereUniform air, float min_mu_s) {
  return (distance_to_top(air, 0.0f, min_mu_s) - air.top_m) / (air.rho_top_m - air.top_m);
}

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

SHARED_END
#endif
