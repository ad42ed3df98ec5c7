#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>

#include "atmosphere/atmosphere_probe.h"
#include "geo/planet_view.h"
#include "gpu/device.h"
#include "probe_tables.h"

namespace nepho {

namespace {

using Case = AtmosphereProbe::Case;
using Answer = AtmosphereProbe::Answer;

// What rounding in tables of other programs may leave.
constexpr double kHeightSlack_m = 1.0;
constexpr double kCosineSlack = 1e-6;
constexpr double kUnitSlack = 1e-3;
constexpr double kHorizonSlack_m = 1.0;
/// Paths may dip so far, as between points of a coarse sphere of triangles.
constexpr double kBuriedPath_m = 500.0;
/// Beyond it single precision has no room for squares of lengths.
constexpr double kFarthest_m = 1e12;

dvec3 scaled(const dvec3& v, const Ellipsoid& planet) { return {v.x, v.y, v.z * planet.a_over_b()}; }

/// Height above the sphere that the ellipsoid is in scaled space, m.
double scaled_height_m(const dvec3& position_m, const Ellipsoid& planet) {
  return glm::length(scaled(position_m, planet)) - planet.a_m;
}

/// The same of the lowest point of a ray's first `length_m`, m. Negative: it meets the ground, and does not only rise
/// from a camera that rounding has put below it.
double lowest_height_m(const dvec3& camera_m, const dvec3& dir, double length_m, const Ellipsoid& planet) {
  const dvec3 q = scaled(camera_m, planet), path = scaled(glm::normalize(dir), planet);
  const double lowest_at_m = -glm::dot(q, path) / glm::dot(path, path);
  if (lowest_at_m <= 0.0) return std::max(glm::length(q) - planet.a_m, 0.0);
  return glm::length(q + std::min(lowest_at_m, length_m) * path) - planet.a_m;
}
/// The same of a ray without end from scaled height `h` under a zenith cosine.
double lowest_height_m(double h, double mu, const Ellipsoid& planet) {
  return mu < 0.0 ? (planet.a_m + h) * std::sqrt((1.0 - mu) * (1.0 + mu)) - planet.a_m : h;
}

/// The rows of a table, checked as they are read, and the planet that they are on.
class AirTable {
 public:
  AirTable(const ProbeTable& in, const AtmosphereParams& air)
      : in_(in), air_(air), planet_{.a_m = air.equatorial_radius_m, .b_m = air.polar_radius_m} {}
  const Ellipsoid& planet() const { return planet_; }
  const AtmosphereParams& air() const { return air_; }
  bool given(const std::string& column) const { return in_.given(column); }
  Error bad_cell(size_t row, const std::string& column, const std::string& why) const {
    return in_.bad_cell(row, column, why);
  }

  /// Scaled height within the air from a distance from the centre.
  double height_m(size_t row, const std::string& column) const {
    const double h = in_.numbers(column)[row] - planet_.a_m;
    require_above_ground(row, column, h);
    if (h > air_.top_height_m + kHeightSlack_m)
      throw bad_cell(row, column,
                     fmt::format("the height {} m is above the air, which ends at {} m", h, air_.top_height_m));
    return std::clamp(h, 0.0, air_.top_height_m);
  }
  double cosine(size_t row, const std::string& column) const {
    const double value = in_.numbers(column)[row];
    if (std::abs(value) > 1.0 + kCosineSlack)
      throw bad_cell(row, column, fmt::format("{} is outside -1..1, and no cosine", value));
    return std::clamp(value, -1.0, 1.0);
  }
  /// 0 or 1; nothing without the column.
  std::optional<bool> flag(size_t row, const std::string& column) const {
    if (!in_.given(column)) return {};
    const double value = in_.numbers(column)[row];
    if (std::isnan(value)) return {};
    if (value != 0.0 && value != 1.0) throw bad_cell(row, column, fmt::format("{} is neither 0 nor 1", value));
    return value == 1.0;
  }
  dvec3 unit(size_t row, const std::string& name) const {
    const dvec3 v = xyz(row, name, "");
    const double length = glm::length(v);
    if (!(std::abs(length - 1.0) <= kUnitSlack))
      throw bad_cell(row, name + "_x", fmt::format("the vector {}_x, _y, _z has the length {}, not 1", name, length));
    return v / length;
  }
  /// A geocentric position, anywhere above the ground.
  dvec3 position(size_t row, const std::string& name) const {
    const dvec3 p = xyz(row, name, "_m");
    const std::string column = name + "_x_m";
    if (!(glm::length(p) <= kFarthest_m))
      throw bad_cell(row, column, fmt::format("the point is {:g} m away; at most {:g}", glm::length(p), kFarthest_m));
    require_above_ground(row, column, scaled_height_m(p, planet_));
    return p;
  }
  /// Whether a ray whose lowest height is `lowest_m` ends on the ground: as the column says where there is one, which
  /// must be possible.
  bool hits_ground(size_t row, double lowest_m) const {
    const std::optional<bool> said = flag(row, "hits_ground");
    if (!said) return lowest_m < 0.0;
    if (*said && lowest_m > kHorizonSlack_m)
      throw bad_cell(row, "hits_ground", fmt::format("1, but the ray passes {:g} m above the ground", lowest_m));
    if (!*said && lowest_m < -kHorizonSlack_m)
      throw bad_cell(row, "hits_ground", fmt::format("0, but the ray goes {:g} m under the ground", -lowest_m));
    return *said;
  }

 private:
  dvec3 xyz(size_t row, const std::string& name, const std::string& suffix) const {
    return {in_.numbers(name + "_x" + suffix)[row], in_.numbers(name + "_y" + suffix)[row],
            in_.numbers(name + "_z" + suffix)[row]};
  }
  void require_above_ground(size_t row, const std::string& column, double height_m) const {
    if (!(height_m >= -kHeightSlack_m))
      throw bad_cell(row, column,
                     fmt::format("the point is {:g} m below the ground; the planet's radius is {} m", -height_m,
                                 planet_.a_m == planet_.b_m ? fmt::format("{}", planet_.a_m)
                                                            : fmt::format("{} to {}", planet_.b_m, planet_.a_m)));
  }

  const ProbeTable& in_;
  const AtmosphereParams& air_;
  Ellipsoid planet_;
};

/// What a camera sees along `dir`; for a point at `distance_m`, up to it.
Case view_case(const dvec3& camera_m, const dvec3& dir, const dvec3& sun, bool hits_ground, double distance_m,
               const Ellipsoid& planet) {
  Case c{};
  c.planet = make_planet_view(camera_m, planet);
  c.dir = vec3(glm::normalize(dir));
  c.sun_dir = vec3(sun);
  c.camera_up = vec3(glm::normalize(scaled(scaled(camera_m, planet), planet)));
  c.hits_ground = hits_ground ? 1u : 0u;
  c.distance_m = static_cast<float>(distance_m);
  return c;
}

Case height_case(double h) {
  Case c{};
  // Not read by these kinds, but the shader looks at all of a case.
  c.planet.a_m = c.planet.a_over_b = 1.0f;
  c.dir = c.sun_dir = c.camera_up = vec3(0.0f, 0.0f, 1.0f);
  c.h = static_cast<float>(h);
  return c;
}

Case transmittance_case(const AirTable& in, size_t row) {
  const double h = in.height_m(row, "r_m"), mu = in.cosine(row, "mu");
  Case c = height_case(h);
  c.mu = static_cast<float>(mu);
  c.hits_ground = lowest_height_m(h, mu, in.planet()) < -kHorizonSlack_m ? 1u : 0u;
  return c;
}

Case single_scattering_case(const AirTable& in, size_t row) {
  const double h = in.height_m(row, "r_m"), mu = in.cosine(row, "mu"), mu_s = in.cosine(row, "mu_s"),
               nu = in.cosine(row, "nu");
  const double spread = std::sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s));
  if (std::abs(nu - mu * mu_s) > spread + 1e-4)
    throw in.bad_cell(row, "nu",
                      fmt::format("{} is not possible with mu {} and mu_s {}: {:.6g}..{:.6g}", nu, mu, mu_s,
                                  mu * mu_s - spread, mu * mu_s + spread));
  Case c = height_case(h);
  c.mu = static_cast<float>(mu);
  c.mu_s = static_cast<float>(mu_s);
  c.nu = static_cast<float>(nu);
  c.hits_ground = in.hits_ground(row, lowest_height_m(h, mu, in.planet())) ? 1u : 0u;
  return c;
}

Case irradiance_case(const AirTable& in, size_t row) {
  Case c = height_case(in.height_m(row, "r_m"));
  c.mu_s = static_cast<float>(in.cosine(row, "mu_s"));
  return c;
}

Case sky_case(const AirTable& in, size_t row) {
  const dvec3 camera = in.position(row, "cam"), view = in.unit(row, "view"), sun = in.unit(row, "sun");
  const bool hits =
      in.hits_ground(row, lowest_height_m(camera, view, std::numeric_limits<double>::infinity(), in.planet()));
  return view_case(camera, view, sun, hits, 0.0, in.planet());
}

Case point_case(const AirTable& in, size_t row) {
  const dvec3 camera = in.position(row, "cam"), point = in.position(row, "pt"), sun = in.unit(row, "sun");
  const double distance_m = glm::length(point - camera);
  const dvec3 dir = distance_m > 0.0 ? point - camera : camera;  // without a distance any will do
  const double lowest_m = lowest_height_m(camera, dir, distance_m, in.planet());
  if (lowest_m < -kBuriedPath_m)
    throw in.bad_cell(row, "pt_x_m",
                      fmt::format("the point is hidden: the way to it goes {:g} m under the ground", -lowest_m));
  return view_case(camera, dir, sun, true, distance_m, in.planet());
}

Case sun_sky_case(const AirTable& in, size_t row) {
  const dvec3 point = in.position(row, "pt"), normal = in.unit(row, "n"), sun = in.unit(row, "sun");
  Case c = view_case(point, normal, sun, false, 0.0, in.planet());
  const dvec3 up = glm::normalize(scaled(scaled(point, in.planet()), in.planet()));
  c.h = static_cast<float>(std::max(scaled_height_m(point, in.planet()), 0.0));
  c.mu_s = static_cast<float>(glm::dot(up, sun));
  return c;
}

/// A kind of probe: what is asked of the shader, and what its two answers are called.
struct AirKind {
  const char* name;
  std::vector<ProbeInput> inputs;
  uint32_t shader_kind;
  Case (*make_case)(const AirTable&, size_t row);
  const char* first;
  const char* second;          ///< null: one answer only
  bool opaque_ground = false;  ///< transmittance is 0 along rays that end there
};

std::vector<ProbeColumn> evaluate(const AirKind& kind, const ProbeTable& in, const ProbeOptions& options) {
  AtmosphereParams air = resolved(options.scene.atmosphere);
  air.spectral = "fast";  // results are of the three wavelengths
  const AirTable table(in, air);
  std::vector<Case> cases;
  for (size_t row = 0; row < in.rows(); ++row) cases.push_back(kind.make_case(table, row));
  std::vector<Answer> answers;
  if (!cases.empty()) {
    gpu::Device device({.device = options.device});
    answers =
        AtmosphereProbe(device, std::make_shared<const AtmosphereTables>(device, air)).ask(kind.shader_kind, cases);
  }

  std::vector<ProbeColumn> columns;
  for (const char* name : {kind.first, kind.second}) {
    if (!name) continue;
    for (int i = 0; i < 3; ++i) {
      constexpr const char* kWavelengths[] = {"680", "550", "440"};
      ProbeColumn column{fmt::format("{}_{}", name, kWavelengths[i]), {}};
      const bool transmittance = name == std::string_view("T");
      for (size_t row = 0; row < answers.size(); ++row) {
        const bool blocked = transmittance && kind.opaque_ground && cases[row].hits_ground != 0;
        const vec3& answer = name == kind.first ? answers[row].a : answers[row].b;
        column.values.push_back(blocked ? 0.0 : static_cast<double>(answer[i]));
        if (!std::isfinite(column.values.back()))
          throw fail(ErrorKind::failure, "{} is {}: please report it",
                     in.bad_cell(row, column.name, "the result").what(), column.values.back());
      }
      columns.push_back(std::move(column));
    }
  }
  return columns;
}

std::vector<ProbeInput> numbers(std::initializer_list<const char*> names) {
  std::vector<ProbeInput> inputs;
  for (const char* name : names) inputs.push_back({name});
  return inputs;
}

/// Columns NAME_x, NAME_y, NAME_z, each with a suffix, of several names.
std::vector<ProbeInput> vectors(std::initializer_list<std::pair<const char*, const char*>> names) {
  std::vector<ProbeInput> inputs;
  for (const auto& [name, suffix] : names)
    for (const char* axis : {"_x", "_y", "_z"}) inputs.push_back({name + std::string(axis) + suffix});
  return inputs;
}

const std::vector<AirKind>& air_kinds() {
  static const std::vector<AirKind> kinds = [] {
    std::vector<ProbeInput> sky = vectors({{"cam", "_m"}, {"view", ""}, {"sun", ""}});
    sky.push_back({"hits_ground", ProbeInput::Type::number, "ground"});  // by the geometry, where it is not given
    return std::vector<AirKind>{
        {"transmittance", numbers({"r_m", "mu"}), shared::kProbeTransmittance, transmittance_case, "T", nullptr, true},
        {"single_scattering", numbers({"r_m", "mu", "mu_s", "nu", "hits_ground"}), shared::kProbeSingleScattering,
         single_scattering_case, "ray", "mie"},
        {"ground_irradiance", numbers({"r_m", "mu_s"}), shared::kProbeIrradiance, irradiance_case, "direct",
         "indirect"},
        {"sky_radiance", sky, shared::kProbeSkyRadiance, sky_case, "L", "T", true},
        {"sky_radiance_to_point", vectors({{"cam", "_m"}, {"pt", "_m"}, {"sun", ""}}), shared::kProbeRadianceToPoint,
         point_case, "L", "T"},
        {"sun_sky_irradiance", vectors({{"pt", "_m"}, {"n", ""}, {"sun", ""}}), shared::kProbeSunSky, sun_sky_case,
         "sun", "sky"}};
  }();
  return kinds;
}

}  // namespace

std::vector<ProbeKind> atmosphere_probe_kinds() {
  std::vector<ProbeKind> kinds;
  for (const AirKind& kind : air_kinds())
    kinds.push_back({kind.name, kind.inputs, [&kind](const ProbeTable& in, const ProbeOptions& options) {
                       return evaluate(kind, in, options);
                     }});
  return kinds;
}

}  // namespace nepho
