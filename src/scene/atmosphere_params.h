#pragma once
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace nepho {

/// One species of the air with an exponential profile, at the rendering wavelengths 680, 550, 440 nm.
struct RayleighParams {
  /// Scattering at height 0, 1/m, >= 0. 1.24062e-6 lambda_um^-4 (Bruneton 2017, demo).
  glm::dvec3 scattering_per_m = {5.80233938171e-06, 1.35577624479e-05, 3.31000059764e-05};
  double scale_height_m = 8000.0;  ///< e-folding height of density, m, > 0
  bool operator==(const RayleighParams&) const = default;
};

/// Aerosol. The defaults are clean continental air: optical depth 0.03 at 550 nm, Angstrom exponent 1.3, single
/// scattering albedo 0.95 (order of AERONET's clean rural sites); visibility about 100 km.
struct MieParams {
  /// Scattering at height 0, 1/m, >= 0.
  glm::dvec3 scattering_per_m = {1.8e-5, 2.38e-5, 3.18e-5};
  /// Extinction at height 0, 1/m, >= scattering.
  glm::dvec3 extinction_per_m = {1.9e-5, 2.5e-5, 3.34e-5};
  double scale_height_m = 1200.0;         ///< m, > 0
  double phase_g = 0.8;                   ///< asymmetry of the phase function, -0.99..0.99
  std::string phase = "cornette-shanks";  ///< cornette-shanks, henyey-greenstein
  /// Vertical optical depth at 550 nm; sets the coefficients' level and keeps their spectrum and albedo.
  std::optional<double> optical_depth;
  /// Meteorological visibility at height 0 (Koschmieder: 3.912 / extinction at 550 nm, gas included), m; the same.
  std::optional<double> visibility_m;
  bool operator==(const MieParams&) const = default;
};

/// Ozone: absorbs only; a tent of density 1 at `center_m`, 0 at center -+ half_width.
struct OzoneParams {
  glm::dvec3 absorption_per_m = {6.497166e-07, 1.8809e-06, 8.501668e-08};  ///< at the tent's top, 1/m, >= 0 (300 DU)
  double center_m = 25000.0;                                               ///< m
  double half_width_m = 15000.0;                                           ///< m, > 0
  std::optional<double> column_du;  ///< Dobson units of terrestrial ozone; replaces absorption_per_m
  bool operator==(const OzoneParams&) const = default;
};

/// Clear air over an ellipsoid. Equal parameters keep their tables.
struct AtmosphereParams {
  double equatorial_radius_m = 6378137.0;     ///< a, m. Default: WGS84
  double polar_radius_m = 6356752.314245179;  ///< b, m
  double top_height_m = 100000.0;             ///< where the air ends, above the ground, m; >= 3 scale heights
  RayleighParams rayleigh;
  MieParams mie;
  OzoneParams ozone;
  /// Sun at 1 au at the top of the atmosphere, W m^-2 nm^-1 at 680, 550, 440 nm (ASTM G173 as in Bruneton 2017).
  glm::dvec3 solar_irradiance_W_m2_nm = {1.474, 1.8504, 1.91198};
  double ground_albedo = 0.1;                   ///< mean albedo that lights the sky from below, 0..1
  double min_sun_zenith_cos = -0.342020143326;  ///< sun cosine down to which the tables reach, then light fades; cos 110 deg
  int scattering_orders = 4;                    ///< >= 1; 1 is single scattering
  std::string spectral = "full";                ///< fast: three wavelengths; full: fifteen, summed to luminance
  bool operator==(const AtmosphereParams&) const = default;

  static AtmosphereParams earth() { return {}; }
  /// The spherical planet of Bruneton's demo: radius 6360 km, air up to 60 km.
  static AtmosphereParams bruneton_demo();
};

/// The air of a name in atmosphere_preset_names(); nothing for any other name.
std::optional<AtmosphereParams> atmosphere_preset(const std::string& name);
/// "earth", "bruneton-demo".
const std::vector<std::string>& atmosphere_preset_names();

/// What is wrong with an atmosphere, and which of its members says so.
struct AtmosphereProblem {
  std::string member;  ///< "mie.visibility_m", "rayleigh.scattering_per_m[1]"
  std::string reason;  ///< "1e6 is more than gas alone allows; at most 288543 m"
};
/// The first rule between parameters that is broken, if any (ranges of single ones: scene_validate.h): contradictions,
/// air clearer than gas alone, air thinner than 3 scale heights, a vertical optical depth above 100, extinction below
/// scattering, radii that do not fit. NaN breaks the rule that meets it.
std::optional<AtmosphereProblem> find_problem(const AtmosphereParams& params);

/// The same air with optical_depth, visibility_m and column_du worked into the coefficients, and empty:
/// - optical_depth = extinction at height 0 times scale height (of an exponential profile without a top);
/// - visibility_m: Koschmieder 1924, 3.912 / (extinction of aerosol and gas at 550 nm);
/// - column_du: 300 DU are the default absorption over the default tent; only the part of the tent in the air counts.
/// Throws Error(usage) that names the parameter when find_problem() finds one.
AtmosphereParams resolved(const AtmosphereParams& params);

}  // namespace nepho
