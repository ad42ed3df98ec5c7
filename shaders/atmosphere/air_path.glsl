// Light scattered into a path through the air: direct quadrature, with no difference of two lookups anywhere.
// Needs before the include: `transmittance_tex` and the uniform block `atmosphere` declared, AIR_PATH_NODES (8 or 12).
#include "atmosphere/atmosphere_shared.h"
#include "common/phase.h"

// Wavelengths in threes: 1 or 5, fixed when a pipeline is made.
layout(constant_id = 0) const int kSpectralGroups = 1;

#if AIR_PATH_NODES == 8
#define AIR_PATH_X kGauss8X
#define AIR_PATH_W kGauss8W
#else
#define AIR_PATH_X kGauss12X
#define AIR_PATH_W kGauss12W
#endif

// Columns of gas, aerosol, ozone up to the top of the air, m.
vec3 sampled_columns_to_top(AtmosphereUniform air, float h, float mu) {
  vec2 uv = vec2(texel_coord(unit_from_sky_mu(air, h, mu), kColumnMu), texel_coord(unit_from_height(air, h), kColumnR));
  return textureLod(transmittance_tex, uv, 0.0).rgb;
}

// A path as its quadrature needs it. The columns to a node are differences of two lookups to the top, taken upwards on
// either side of the lowest point; their error multiplies the light and does not grow as the path shrinks.
struct AirPath {
  float h, mu, mu_s, nu;
  float sunlit_m;         // sunlight reaches the first so many metres
  PathPanels panels;
  vec3 columns_at_start;  // upwards from the start
  vec3 columns_at_low;    // from the lowest point
};

AirPath air_path(AtmosphereUniform air, float h, float mu, float mu_s, float nu, float length_m, float sunlit_m) {
  AirPath path;
  path.h = h;
  path.mu = mu;
  path.mu_s = mu_s;
  path.nu = nu;
  path.sunlit_m = sunlit_m;
  path.panels = path_panels(air, h, mu, mu_s, nu, length_m, sunlit_m);
  path.columns_at_start = sampled_columns_to_top(air, h, abs(mu));
  path.columns_at_low = path.columns_at_start;
  if (path.panels.low_m > 0.0) path.columns_at_low = sampled_columns_to_top(air, height_along(air, h, mu, path.panels.low_m), 0.0);
  return path;
}

// Columns from the start to a point on the path, given those from that point upwards. `mu` is the ray's zenith cosine there: a
// ray that descends has not yet passed its lowest point.
vec3 columns_along(AirPath path, float mu, vec3 columns_up) {
  vec3 columns = mu < 0.0 ? columns_up - path.columns_at_start
                 : (path.panels.low_m > 0.0 ? 2.0 * path.columns_at_low - path.columns_at_start : path.columns_at_start) - columns_up;
  return max(columns, vec3(0));
}

struct AirNode {
  float h, mu, mu_s;
  float weight_m;
  float sunlit;          // share of the sun's disc that shines on it
  vec3 density;          // of gas, aerosol, ozone
  vec3 columns;          // from the start of the path
  vec3 columns_to_sun;
};

int node_count(AirPath path) { return path.panels.count * AIR_PATH_NODES; }

AirNode air_node(AtmosphereUniform air, AirPath path, int i) {
  int panel = i / AIR_PATH_NODES;
  int k = i - panel * AIR_PATH_NODES;
  vec2 at = path_node(path.panels, panel, AIR_PATH_X[k], AIR_PATH_W[k]);
  float r = air.radius_m + path.h;
  AirNode node;
  node.weight_m = at.y;
  node.h = height_along(air, path.h, path.mu, at.x);
  float inv_r = 1.0 / (air.radius_m + node.h);
  node.mu = clamp((r * path.mu + at.x) * inv_r, -1.0, 1.0);
  node.mu_s = clamp((r * path.mu_s + at.x * path.nu) * inv_r, -1.0, 1.0);
  node.density = densities(air, node.h);
  node.columns = columns_along(path, node.mu, sampled_columns_to_top(air, node.h, abs(node.mu)));
  node.columns_to_sun = sampled_columns_to_top(air, node.h, node.mu_s);
  node.sunlit = at.x < path.sunlit_m ? sun_visibility(air, node.h, node.mu_s) : 0.0;
  return node;
}

// The columns of the whole path: of many nodes for a short one; for a long one, which they are too few for, from tables.
vec3 path_columns(AtmosphereUniform air, AirPath path, vec3 summed) {
  float length_m = path.panels.end_m;
  float h = height_along(air, path.h, path.mu, length_m);
  float mu = clamp(((air.radius_m + path.h) * path.mu + length_m) / (air.radius_m + h), -1.0, 1.0);
  vec3 tabulated = columns_along(path, mu, sampled_columns_to_top(air, h, abs(mu)));
  return length_m > 30000.0 ? tabulated : summed;
}

// Two reads on either side of the view-sun angle, of a texture with kAirNu x kAirMuS columns. `v` is the row, `w` the slice.
vec4 sample_4d(sampler3D tex, float unit_nu, float unit_mu_s, float v, float w) {
  float x = unit_nu * float(kAirNu - 1);
  float i = min(floor(x), float(kAirNu - 2));
  float u = texel_coord(unit_mu_s, kAirMuS);
  vec4 a = textureLod(tex, vec3((i + u) / float(kAirNu), v, w), 0.0);
  vec4 b = textureLod(tex, vec3((i + 1.0 + u) / float(kAirNu), v, w), 0.0);
  return mix(a, b, x - i);
}

// Four coefficients of the multiply scattered light per unit of scattering coefficient and of sunlight.
vec4 sampled_source(AtmosphereUniform air, sampler3D tex, AirNode node, float nu) {
  return sample_4d(tex, unit_from_nu(nu), unit_from_mu_s(air, node.mu_s), texel_coord(0.5 + 0.5 * node.mu, kSourceMu),
                   texel_coord(unit_from_height(air, node.h), kAirR));
}
