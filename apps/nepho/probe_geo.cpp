#include <glm/vec4.hpp>

#include "geo/frames.h"
#include "geo/geodesic.h"
#include "geo/geoid.h"
#include "probe_tables.h"

namespace nepho {

namespace {

using Type = ProbeInput::Type;

/// Fills one column per name from `row_values(row)`, an array with one number per name.
template <size_t N, typename F>
std::vector<ProbeColumn> by_row(const ProbeTable& in, const std::array<const char*, N>& names, const F& row_values) {
  std::vector<ProbeColumn> columns;
  for (const char* name : names) columns.push_back({name, std::vector<double>(in.rows())});
  for (size_t row = 0; row < in.rows(); ++row) {
    const std::array<double, N> values = row_values(row);
    for (size_t i = 0; i < N; ++i) columns[i].values[row] = values[i];
  }
  return columns;
}

/// Geodetic places from three columns; without a height column at height 0.
class Places {
 public:
  Places(const ProbeTable& in, const std::string& lat, const std::string& lon, const std::string& height = {})
      : lat_(in.numbers(lat)), lon_(in.numbers(lon)) {
    if (!height.empty()) height_ = in.numbers(height);
  }
  Geodetic operator[](size_t row) const {
    return Geodetic::from_degrees(lat_[row], lon_[row], height_.empty() ? 0.0 : height_[row]);
  }

 private:
  std::span<const double> lat_, lon_, height_;
};

std::vector<ProbeColumn> geodetic_ecef(const ProbeTable& in, const ProbeOptions&) {
  const Places places(in, "lat_deg", "lon_deg", "height_m");
  return by_row<3>(in, {"x_m", "y_m", "z_m"}, [&](size_t row) {
    const dvec3 p = ecef_from_geodetic(places[row]);
    return std::array{p.x, p.y, p.z};
  });
}

std::vector<ProbeColumn> ecef_to_geodetic(const ProbeTable& in, const ProbeOptions&) {
  const auto x = in.numbers("x_m"), y = in.numbers("y_m"), z = in.numbers("z_m");
  return by_row<3>(in, {"lat_deg", "lon_deg", "height_m"}, [&](size_t row) {
    const Geodetic at = geodetic_from_ecef(dvec3(x[row], y[row], z[row]));
    return std::array{at.lat_deg(), at.lon_deg(), at.height_m};
  });
}

std::vector<ProbeColumn> enu_frames(const ProbeTable& in, const ProbeOptions&) {
  const Places origins(in, "lat_deg", "lon_deg", "height_m");
  std::vector<ProbeColumn> columns = by_row<9>(
      in, {"east_x", "east_y", "east_z", "north_x", "north_y", "north_z", "up_x", "up_y", "up_z"}, [&](size_t row) {
        const dmat3 m = make_ecef_from_enu_rotation(origins[row]);
        return std::array{m[0].x, m[0].y, m[0].z, m[1].x, m[1].y, m[1].z, m[2].x, m[2].y, m[2].z};
      });
  if (!in.given("target_lat_deg")) return columns;
  const Places targets(in, "target_lat_deg", "target_lon_deg", "target_height_m");
  const auto more = by_row<3>(in, {"target_e_m", "target_n_m", "target_u_m"}, [&](size_t row) {
    const glm::dvec4 target(ecef_from_geodetic(targets[row]), 1.0);
    const glm::dvec4 enu = make_enu_from_ecef(origins[row]) * target;  // NaN, a blank, where the target is blank
    return std::array{enu.x, enu.y, enu.z};
  });
  columns.insert(columns.end(), more.begin(), more.end());
  return columns;
}

std::vector<ProbeColumn> inverse_geodesics(const ProbeTable& in, const ProbeOptions&) {
  const Places from(in, "lat1_deg", "lon1_deg"), to(in, "lat2_deg", "lon2_deg");
  return by_row<10>(in,
                    {"s12_m", "azi1_deg", "azi2_deg", "a12_deg", "q25_lat_deg", "q25_lon_deg", "mid_lat_deg",
                     "mid_lon_deg", "q75_lat_deg", "q75_lon_deg"},
                    [&](size_t row) {
                      const GeodesicInverse g = geodesic_inverse(from[row], to[row]);
                      const GeodesicPath path(from[row], to[row]);
                      const Geodetic q25 = path.at(0.25), mid = path.at(0.5), q75 = path.at(0.75);
                      return std::array{g.distance_m,
                                        deg_from_rad(g.azimuth1_rad),
                                        deg_from_rad(g.azimuth2_rad),
                                        deg_from_rad(g.arc_rad),
                                        q25.lat_deg(),
                                        q25.lon_deg(),
                                        mid.lat_deg(),
                                        mid.lon_deg(),
                                        q75.lat_deg(),
                                        q75.lon_deg()};
                    });
}

std::vector<ProbeColumn> direct_geodesics(const ProbeTable& in, const ProbeOptions&) {
  const Places from(in, "lat1_deg", "lon1_deg");
  const auto azimuth_deg = in.numbers("azi1_deg"), distance_m = in.numbers("s12_m");
  return by_row<3>(in, {"lat2_deg", "lon2_deg", "azi2_deg"}, [&](size_t row) {
    const GeodesicEnd end = geodesic_direct(from[row], rad_from_deg(azimuth_deg[row]), distance_m[row]);
    return std::array{end.point.lat_deg(), end.point.lon_deg(), deg_from_rad(end.azimuth_rad)};
  });
}

std::vector<ProbeColumn> geoid_egm96(const ProbeTable& in, const ProbeOptions&) {
  const Geoid& geoid = Geoid::egm96();
  const Places places(in, "lat_deg", "lon_deg");
  return by_row<2>(in, {"N_bilinear15_m", "N_bicubic15_m"}, [&](size_t row) {
    const Geodetic at = places[row];
    return std::array{geoid.undulation_m(at.lat_rad, at.lon_rad), geoid.undulation_bicubic_m(at.lat_rad, at.lon_rad)};
  });
}

}  // namespace

std::vector<ProbeKind> geo_probe_kinds() {
  const ProbeInput lat{"lat_deg", Type::latitude_deg}, lon{"lon_deg"}, height{"height_m"};
  const ProbeInput lat1{"lat1_deg", Type::latitude_deg}, lat2{"lat2_deg", Type::latitude_deg};
  const ProbeInput lon1{"lon1_deg"}, lon2{"lon2_deg"};
  return {{"geodetic_ecef", {lat, lon, height}, geodetic_ecef},
          {"ecef_to_geodetic", {{"x_m"}, {"y_m"}, {"z_m"}}, ecef_to_geodetic},
          {"enu_frames",
           {lat,
            lon,
            height,
            {"target_lat_deg", Type::latitude_deg, "target"},
            {"target_lon_deg", Type::number, "target"},
            {"target_height_m", Type::number, "target"}},
           enu_frames},
          {"geodesic_inverse", {lat1, lon1, lat2, lon2}, inverse_geodesics},
          {"geodesic_direct", {lat1, lon1, {"azi1_deg"}, {"s12_m"}}, direct_geodesics},
          {"geoid_egm96", {lat, lon}, geoid_egm96}};
}

}  // namespace nepho
