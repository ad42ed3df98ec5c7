#include "scene/atmosphere_params.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace nepho {

namespace {

/// Koschmieder 1924: what is visible has a contrast of 2 % or more, -ln 0.02.
constexpr double kKoschmieder = 3.912;
/// Scale heights that the air must have: beyond them is 5 % of the gas.
constexpr double kMinScaleHeights = 3.0;
/// Through more than this nothing is seen; the cloudless skies of Venus have less.
constexpr double kMaxOpticalDepth = 100.0;

/// Height of a tent of density 1 at its middle that has the ozone's column, m: the part of it between ground and top.
double ozone_column_m(const OzoneParams& ozone, double top_m) {
  // Integral of the tent from its lower end to `x` half widths from its middle.
  const auto up_to = [&](double height_m) {
    const double x = std::clamp((height_m - ozone.center_m) / ozone.half_width_m, -1.0, 1.0);
    return x < 0.0 ? 0.5 * (1.0 + x) * (1.0 + x) : 1.0 - 0.5 * (1.0 - x) * (1.0 - x);
  };
  return ozone.half_width_m * (up_to(top_m) - up_to(0.0));
}

/// Which optional member sets the level of the aerosol; one must be there.
std::string aerosol_member(const MieParams& mie) {
  return mie.optical_depth ? "mie.optical_depth" : "mie.visibility_m";
}

/// Works optical_depth or visibility_m into the coefficients.
std::optional<AtmosphereProblem> resolve_aerosol(MieParams& mie, const RayleighParams& gas) {
  if (!mie.optical_depth && !mie.visibility_m) return {};
  const std::string member = aerosol_member(mie);
  if (mie.optical_depth && mie.visibility_m)
    return AtmosphereProblem{"mie.visibility_m", "mie.optical_depth is given too; keep one of the two"};
  double wanted = 0.0;
  if (mie.optical_depth) {
    wanted = *mie.optical_depth / mie.scale_height_m;
    if (!(*mie.optical_depth >= 0.0))
      return AtmosphereProblem{member, fmt::format("{} is negative", *mie.optical_depth)};
  } else {
    const double gas_alone_m = kKoschmieder / gas.scattering_per_m[1];
    if (!(*mie.visibility_m > 0.0))
      return AtmosphereProblem{member, fmt::format("{} is not above 0", *mie.visibility_m)};
    if (!(*mie.visibility_m <= gas_alone_m))
      return AtmosphereProblem{member, fmt::format("{} m is more than gas alone allows; at most {:.0f} m",
                                                   *mie.visibility_m, std::floor(gas_alone_m))};
    wanted = kKoschmieder / *mie.visibility_m - gas.scattering_per_m[1];
  }
  const double now = mie.extinction_per_m[1];
  if (!(now > 0.0) && wanted > 0.0)
    return AtmosphereProblem{member,
                             "there is no spectrum to scale: mie.extinction_per_m is 0 at 550 nm; give it a value"};
  const double scale = now > 0.0 ? wanted / now : 0.0;
  mie.extinction_per_m *= scale;
  mie.scattering_per_m *= scale;
  mie.optical_depth.reset();
  mie.visibility_m.reset();
  return {};
}

std::optional<AtmosphereProblem> resolve_ozone(OzoneParams& ozone, double top_m) {
  if (!ozone.column_du) return {};
  // Bruneton 2017: 300 DU are 6.497e-7, 1.881e-6, 8.502e-8 1/m at the top of a tent of half width 15 km.
  const OzoneParams standard;
  const glm::dvec3 per_du = standard.absorption_per_m * (standard.half_width_m / 300.0);
  const double column_m = ozone_column_m(ozone, top_m);
  if (!(*ozone.column_du >= 0.0))
    return AtmosphereProblem{"ozone.column_du", fmt::format("{} is negative", *ozone.column_du)};
  if (!(column_m > 0.0) && *ozone.column_du > 0.0)
    return AtmosphereProblem{"ozone.column_du",
                             fmt::format("there is no room for ozone: ozone.center_m {} -+ half_width_m {} is not in "
                                         "the air, 0..{} m",
                                         ozone.center_m, ozone.half_width_m, top_m)};
  ozone.absorption_per_m = column_m > 0.0 ? per_du * (*ozone.column_du / column_m) : glm::dvec3(0.0);
  ozone.column_du.reset();
  return {};
}

std::optional<AtmosphereProblem> problem_of_shape(const AtmosphereParams& p) {
  if (!(p.polar_radius_m <= p.equatorial_radius_m))
    return AtmosphereProblem{"polar_radius_m", fmt::format("{} is larger than equatorial_radius_m {}", p.polar_radius_m,
                                                           p.equatorial_radius_m)};
  if (!(p.polar_radius_m >= 0.5 * p.equatorial_radius_m))
    return AtmosphereProblem{"polar_radius_m", fmt::format("{} is less than half of equatorial_radius_m {}",
                                                           p.polar_radius_m, p.equatorial_radius_m)};
  if (!(p.top_height_m <= 0.5 * p.equatorial_radius_m))
    return AtmosphereProblem{"top_height_m", fmt::format("{} is more than half of equatorial_radius_m {}",
                                                         p.top_height_m, p.equatorial_radius_m)};
  const std::pair<const char*, double> species[] = {{"rayleigh", p.rayleigh.scale_height_m},
                                                    {"mie", p.mie.scale_height_m}};
  for (const auto& [name, scale_height_m] : species)
    if (!(p.top_height_m >= kMinScaleHeights * scale_height_m))
      return AtmosphereProblem{
          "top_height_m",
          fmt::format("the air is too thin: {} m are less than {:.0f} times {}.scale_height_m {}; at "
                      "least {} m",
                      p.top_height_m, kMinScaleHeights, name, scale_height_m, kMinScaleHeights * scale_height_m)};
  return {};
}

/// `given` names what set the coefficients of `air`.
std::optional<AtmosphereProblem> problem_of_light(const AtmosphereParams& air, const AtmosphereParams& given) {
  for (int i = 0; i < 3; ++i) {
    if (!(air.mie.extinction_per_m[i] >= air.mie.scattering_per_m[i]))
      return AtmosphereProblem{
          fmt::format("mie.extinction_per_m[{}]", i),
          fmt::format("{} is less than scattering_per_m {}", air.mie.extinction_per_m[i], air.mie.scattering_per_m[i])};
    // Whatever is most opaque gets the blame.
    const auto at = [&](const char* member) { return fmt::format("{}[{}]", member, i); };
    const std::pair<std::string, double> depths[] = {
        {at("rayleigh.scattering_per_m"), air.rayleigh.scattering_per_m[i] * air.rayleigh.scale_height_m},
        {given.mie.optical_depth || given.mie.visibility_m ? aerosol_member(given.mie) : at("mie.extinction_per_m"),
         air.mie.extinction_per_m[i] * air.mie.scale_height_m},
        {given.ozone.column_du ? "ozone.column_du" : at("ozone.absorption_per_m"),
         air.ozone.absorption_per_m[i] * ozone_column_m(air.ozone, air.top_height_m)}};
    double sum = 0.0;
    for (const auto& depth : depths) sum += depth.second;
    if (sum <= kMaxOpticalDepth) continue;
    const auto& most = *std::max_element(std::begin(depths), std::end(depths), [](const auto& a, const auto& b) {
      return !(std::isnan(a.second)) && (std::isnan(b.second) || a.second < b.second);
    });
    constexpr int kWavelengths_nm[] = {680, 550, 440};
    return AtmosphereProblem{
        most.first, fmt::format("gives the air a vertical optical depth of {:.4g} at {} nm; at most {:.0f}", sum,
                                kWavelengths_nm[i], kMaxOpticalDepth)};
  }
  return {};
}

std::optional<AtmosphereProblem> resolve(AtmosphereParams& air) {
  const AtmosphereParams given = air;
  if (auto problem = problem_of_shape(air)) return problem;
  if (auto problem = resolve_aerosol(air.mie, air.rayleigh)) return problem;
  if (auto problem = resolve_ozone(air.ozone, air.top_height_m)) return problem;
  return problem_of_light(air, given);
}

}  // namespace

AtmosphereParams AtmosphereParams::bruneton_demo() {
  AtmosphereParams demo;
  demo.equatorial_radius_m = 6360000.0;
  demo.polar_radius_m = 6360000.0;
  demo.top_height_m = 60000.0;
  demo.mie.scattering_per_m = glm::dvec3(3.996e-6);  // 0.9 of the extinction, 5.328e-3 / 1200 m
  demo.mie.extinction_per_m = glm::dvec3(4.44e-6);
  return demo;
}

const std::vector<std::string>& atmosphere_preset_names() {
  static const std::vector<std::string> names{"earth", "bruneton-demo"};
  return names;
}

std::optional<AtmosphereParams> atmosphere_preset(const std::string& name) {
  if (name == "earth") return AtmosphereParams::earth();
  if (name == "bruneton-demo") return AtmosphereParams::bruneton_demo();
  return std::nullopt;
}

std::optional<AtmosphereProblem> find_problem(const AtmosphereParams& params) {
  AtmosphereParams air = params;
  return resolve(air);
}

AtmosphereParams resolved(const AtmosphereParams& params) {
  AtmosphereParams air = params;
  if (const auto problem = resolve(air))
    throw fail(ErrorKind::usage, "atmosphere.{}: {}", problem->member, problem->reason);
  return air;
}

}  // namespace nepho
