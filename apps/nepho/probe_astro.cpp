#include <cmath>
#include <limits>
#include <optional>

#include "astro/sky_bodies.h"
#include "probe_tables.h"

namespace nepho {

namespace {

constexpr double kBlank = std::numeric_limits<double>::quiet_NaN();

/// All that one row of the ephemeris table is written from.
struct SkyRow {
  UtcInstant utc;
  SkyBodies sky;
  Horizontal sun{kBlank, kBlank, kBlank}, moon{kBlank, kBlank, kBlank};  ///< blank without an observer
};

/// When a result column is written.
enum class Written { always, without_tt_input, with_observer };

struct ResultColumn {
  const char* name;
  double (*value)(const SkyRow&);
  Written written = Written::always;
};

// In the order of the oracle table.
const ResultColumn kResults[] = {
    {"jd_ut", [](const SkyRow& r) { return r.utc.julian_date(); }},
    {"tt_minus_ut_s", [](const SkyRow& r) { return r.sky.tt_minus_ut_s; }, Written::without_tt_input},
    {"gast_deg", [](const SkyRow& r) { return deg_from_rad(r.sky.gast_rad); }},
    {"sun_x", [](const SkyRow& r) { return r.sky.sun.dir_ecef.x; }},
    {"sun_y", [](const SkyRow& r) { return r.sky.sun.dir_ecef.y; }},
    {"sun_z", [](const SkyRow& r) { return r.sky.sun.dir_ecef.z; }},
    {"sun_dist_au", [](const SkyRow& r) { return r.sky.sun.distance_au; }},
    {"sun_ang_radius_deg", [](const SkyRow& r) { return deg_from_rad(r.sky.sun.angular_radius_rad); }},
    {"moon_x", [](const SkyRow& r) { return r.sky.moon.dir_ecef.x; }},
    {"moon_y", [](const SkyRow& r) { return r.sky.moon.dir_ecef.y; }},
    {"moon_z", [](const SkyRow& r) { return r.sky.moon.dir_ecef.z; }},
    {"moon_dist_km", [](const SkyRow& r) { return r.sky.moon.distance_m / 1e3; }},
    {"moon_ang_radius_deg", [](const SkyRow& r) { return deg_from_rad(r.sky.moon.angular_radius_rad); }},
    {"moon_illuminated_fraction", [](const SkyRow& r) { return r.sky.moon.illuminated_fraction; }},
    {"moon_phase_angle_deg", [](const SkyRow& r) { return deg_from_rad(r.sky.moon.phase_angle_rad); }},
    {"moon_ecl_elongation_deg", [](const SkyRow& r) { return deg_from_rad(r.sky.moon.ecliptic_elongation_rad); }},
    {"sun_elev_deg", [](const SkyRow& r) { return deg_from_rad(r.sun.elevation_rad); }, Written::with_observer},
    {"sun_az_deg", [](const SkyRow& r) { return deg_from_rad(r.sun.azimuth_rad); }, Written::with_observer},
    {"moon_topo_elev_deg", [](const SkyRow& r) { return deg_from_rad(r.moon.elevation_rad); }, Written::with_observer},
    {"moon_topo_az_deg", [](const SkyRow& r) { return deg_from_rad(r.moon.azimuth_rad); }, Written::with_observer},
    {"moon_topo_dist_km", [](const SkyRow& r) { return r.moon.distance_m / 1e3; }, Written::with_observer},
};

SkyRow sky_row(const ProbeTable& in, size_t row) {
  SkyRow r;
  try {
    r.utc = parse_utc(in.texts("utc")[row]);
  } catch (const Error& e) {
    throw in.bad_cell(row, "utc", e.what());
  }
  const double tt_s = in.given("tt_minus_ut_s") ? in.numbers("tt_minus_ut_s")[row] : kBlank;
  if (std::abs(tt_s) > 1e5) throw in.bad_cell(row, "tt_minus_ut_s", "the number is outside -100000..100000 s");
  r.sky = sky_bodies_at(r.utc, std::isnan(tt_s) ? std::nullopt : std::optional(tt_s));
  if (in.given("obs_lat_deg") && !std::isnan(in.numbers("obs_lat_deg")[row])) {
    const Geodetic observer = Geodetic::from_degrees(in.numbers("obs_lat_deg")[row], in.numbers("obs_lon_deg")[row],
                                                     in.numbers("obs_height_m")[row]);
    r.sun = horizontal_from_ecef(observer, r.sky.sun.dir_ecef, r.sky.sun.distance_au * kAstronomicalUnit_m);
    r.moon = horizontal_from_ecef(observer, r.sky.moon.dir_ecef, r.sky.moon.distance_m);
  }
  return r;
}

std::vector<ProbeColumn> ephemeris(const ProbeTable& in, const ProbeOptions&) {
  std::vector<SkyRow> rows;
  for (size_t row = 0; row < in.rows(); ++row) rows.push_back(sky_row(in, row));
  std::vector<ProbeColumn> columns;
  for (const ResultColumn& result : kResults) {
    if (result.written == Written::without_tt_input && in.given("tt_minus_ut_s")) continue;
    if (result.written == Written::with_observer && !in.given("obs_lat_deg")) continue;
    ProbeColumn column{result.name, {}};
    for (const SkyRow& row : rows) column.values.push_back(result.value(row));
    columns.push_back(std::move(column));
  }
  return columns;
}

}  // namespace

std::vector<ProbeKind> astro_probe_kinds() {
  using Type = ProbeInput::Type;
  return {{"ephemeris",
           {{"utc", Type::text},
            {"tt_minus_ut_s", Type::number, "tt"},
            {"obs_lat_deg", Type::latitude_deg, "obs"},
            {"obs_lon_deg", Type::number, "obs"},
            {"obs_height_m", Type::number, "obs"}},
           ephemeris}};
}

}  // namespace nepho
