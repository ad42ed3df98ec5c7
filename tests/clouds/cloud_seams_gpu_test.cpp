// No seams: the jump of every field over 20 m across cube edges, corners, poles and the antimeridian is that of steps
// beside them.
#include <algorithm>
#include <array>
#include <cmath>

#include "clouds/cloud_test_tools.h"
#include "geo/cube_sphere.h"
#include "io/array_raster.h"

namespace nepho::test {
namespace {

/// A line or point of the sphere across which a map could show a seam.
struct Seam {
  std::string name;
  std::vector<dvec3> points;  ///< in scaled space (directions by which maps are looked up)
  dvec3 across{0.0};          ///< normal of the seam's plane; 0: a point, which is crossed in all directions
};

/// The twelve edges of the cube of normalize(S p), its eight corners, the poles, and the antimeridian.
std::vector<Seam> all_seams(size_t steps, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<Seam> seams;
  for (int axis = 0; axis < 3; ++axis)
    for (const double a : {-1.0, 1.0})
      for (const double b : {-1.0, 1.0}) {
        Seam seam{.name = "edges", .points = {}, .across = dvec3(0.0)};
        const auto point = [&](double along) {
          dvec3 p(0.0);
          p[axis] = along;
          p[(axis + 1) % 3] = a;
          p[(axis + 2) % 3] = b;
          return p;
        };
        for (size_t i = 0; i < steps; ++i) seam.points.push_back(glm::normalize(point(uniform(random))));
        seam.across = glm::normalize(glm::cross(point(1.0), point(-1.0)));
        seams.push_back(seam);
      }
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 at(corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0, corner & 4 ? 1.0 : -1.0);
    seams.push_back({"corners", std::vector<dvec3>(steps, glm::normalize(at)), dvec3(0.0)});
  }
  for (const double z : {-1.0, 1.0})
    seams.push_back({"poles", std::vector<dvec3>(4 * steps, dvec3(0, 0, z)), dvec3(0.0)});
  Seam antimeridian{.name = "antimeridian", .points = {}, .across = dvec3(0.0, 1.0, 0.0)};
  for (size_t i = 0; i < 8 * steps; ++i) {
    const double lat = std::asin(uniform(random));
    antimeridian.points.push_back({-std::cos(lat), 0.0, std::sin(lat)});
  }
  seams.push_back(antimeridian);
  return seams;
}

/// Two probe points `step_m` apart; the seam is somewhere between them, or `shift_m` away.
struct Step {
  Geodetic from, to;
};
Step make_step(const Seam& seam, size_t i, double step_m, double shift_m, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const dvec3 at = seam.points[i];
  dvec3 across = seam.across;
  if (across == dvec3(0.0)) {  // any direction: through the point, or beside it
    const dvec3 side = glm::normalize(glm::cross(at, dvec3(0.31, -0.72, 0.61)));
    const double turn = 2.0 * M_PI * uniform(random);
    across = std::cos(turn) * side + std::sin(turn) * glm::cross(at, side);
  }
  constexpr double kRadius_m = 6378137.0;
  const double before = step_m * (0.05 + 0.9 * uniform(random));
  dvec3 step = across;
  if (seam.across == dvec3(0.0) && shift_m != 0.0) {
    const double turn = 2.0 * M_PI * uniform(random);
    step = std::cos(turn) * across + std::sin(turn) * glm::cross(at, across);
  }
  const dvec3 from = at + (across * shift_m - step * before) / kRadius_m;
  const dvec3 to = from + step * (step_m / kRadius_m);
  const auto place = [](const dvec3& scaled) {
    const Ellipsoid e = Ellipsoid::wgs84();
    const dvec3 p = glm::normalize(scaled) * e.a_m;
    Geodetic g = geodetic_from_ecef(dvec3(p.x, p.y, p.z / e.a_over_b()));
    g.height_m = 0.0;
    return g;
  };
  return {place(from), place(to)};
}

/// Jumps of some channels across seams and beside them, pooled by kind of seam.
struct Jumps {
  std::vector<double> across, beside;
};
struct Kind {
  std::string name;
  std::vector<Jumps> channels;
};

using Cases = std::vector<CloudProbe::Case>;
/// `values(cases)`: one vector of channels per case. `time` and `height` give each step's own.
template <typename Values, typename Time, typename Height>
std::vector<Kind> measure(const std::vector<Seam>& seams, double step_m, size_t channels, std::mt19937& random,
                          Values&& values, Time&& time, Height&& height, bool only_where_something = false) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<Kind> kinds;
  for (const Seam& seam : seams) {
    if (kinds.empty() || kinds.back().name != seam.name) kinds.push_back({seam.name, std::vector<Jumps>(channels)});
    constexpr size_t kControls = 10;
    Cases cases;
    for (size_t i = 0; i < seam.points.size(); ++i)
      for (size_t k = 0; k <= kControls; ++k) {
        const double shift = k == 0 ? 0.0 : (uniform(random) < 0.5 ? -1.0 : 1.0) * (100.0 + 4900.0 * uniform(random));
        Step step = make_step(seam, i, step_m, shift, random);
        const double t = time(random), h = height(random);
        for (Geodetic* g : {&step.from, &step.to}) {
          g->height_m = h;
          cases.push_back({.point = *g, .camera = {}, .time_s = t});
        }
      }
    const std::vector<std::vector<double>> found = values(cases);
    for (size_t i = 0; i < found.size(); i += 2)
      for (size_t c = 0; c < channels; ++c) {
        if (only_where_something && found[i][c] == 0.0 && found[i + 1][c] == 0.0) continue;
        Jumps& jumps = kinds.back().channels[c];
        ((i / 2) % (kControls + 1) == 0 ? jumps.across : jumps.beside)
            .push_back(std::abs(found[i][c] - found[i + 1][c]));
      }
  }
  return kinds;
}

/// Standard error of a percentile, by resampling.
double standard_error(const std::vector<double>& values, double p) {
  std::mt19937 random(5);
  std::uniform_int_distribution<size_t> pick(0, values.size() - 1);
  double sum = 0.0, square = 0.0;
  constexpr int kTimes = 30;
  std::vector<double> again(values.size());
  for (int i = 0; i < kTimes; ++i) {
    for (double& v : again) v = values[pick(random)];
    const double found = percentile(again, p);
    sum += found / kTimes;
    square += found * found / kTimes;
  }
  return std::sqrt(std::max(square - sum * sum, 0.0));
}

/// The limits: median and 99 % at most 1.1 times, the largest at most 1.5 times the controls'. The median and 99 % of
/// some hundred steps are only known within their sampling error, three times which is granted; at full size it is
/// small.
void check_jumps(const std::string& title, const std::vector<Kind>& kinds, const std::vector<std::string>& names) {
  for (const Kind& kind : kinds) {
    std::string line = title + ", " + kind.name + " (median, 99 %, largest over controls'):";
    for (size_t c = 0; c < names.size(); ++c) {
      const Jumps& j = kind.channels[c];
      if (j.beside.empty() || percentile(j.beside, 1.0) == 0.0) {  // nothing there at all
        CHECK(percentile(j.across, 1.0) == 0.0);
        continue;
      }
      double ratio[3], limit[3] = {1.1, 1.1, 1.5};
      const double at[3] = {0.5, 0.99, 1.0};
      for (int k = 0; k < 3; ++k) {
        const double a = percentile(j.across, at[k]), b = percentile(j.beside, at[k]);
        ratio[k] = b > 0.0 ? a / b : a > 0.0 ? 1e9 : 1.0;
        if (k < 2 && b > 0.0 && !j.across.empty()) limit[k] += 3.0 * standard_error(j.across, at[k]) / b;
      }
      char text[160];
      std::snprintf(text, sizeof text, " %s %.2f %.2f %.2f (%zu)", names[c].c_str(), ratio[0], ratio[1], ratio[2],
                    j.across.size());
      line += text;
      CAPTURE(title);
      CAPTURE(kind.name);
      CAPTURE(names[c]);
      for (int k = 0; k < 3; ++k) CHECK(ratio[k] <= limit[k]);
    }
    MESSAGE(line);
  }
}

CloudParams four_layers() {
  CloudParams params;
  params.layers = {genus_layer("cumulus"), genus_layer("altocumulus"), genus_layer("cirrus"),
                   genus_layer("cumulonimbus")};
  const char* channels[4] = {"r", "g", "b", "a"};
  for (size_t l = 0; l < 4; ++l) {
    params.layers[l].weather_channel = channels[l];
    params.layers[l].wind_east_mps = 15.0;
    params.layers[l].wind_north_mps = 7.0;
  }
  // Cloudy, so that every layer is met often.
  params.weather.mean_coverage_r = 0.5;
  params.weather.mean_coverage_g = params.weather.mean_coverage_b = 0.4;
  params.weather.mean_coverage_a = 0.25;
  return params;
}

const std::vector<std::string> kWeatherNames = {
    "r", "g", "b", "a", "type", "base_offset", "density_factor", "precipitation"};

auto weather_values(CloudProbe& probe) {
  return [&probe](const Cases& cases) {
    std::vector<std::vector<double>> out;
    for (const CloudProbe::Weather& w : probe.weather(cases))
      out.push_back({w.coverage.x, w.coverage.y, w.coverage.z, w.coverage.w, w.type, w.base_offset_m, w.density_factor,
                     w.precipitation});
    return out;
  };
}

/// A step's own moment: patterns change every twelve hours, so that even the steps through one pole are of many skies.
/// All are five hours after the middles of their windows: winds have carried the fields 270 km.
double some_moment(std::mt19937& random) {
  return (std::uniform_int_distribution<int>(0, 20000)(random) + 0.5) * kWindow_s + 5.0 * 3600.0;
}

TEST_CASE(
    "gpu: weather jumps no more over 20 m across cube edges, corners, poles and the antimeridian than beside them") {
  GpuFixture gpu;
  std::mt19937 random(1);
  const Clouds clouds(gpu.device, four_layers());
  CloudProbe probe(gpu.device, clouds);
  const std::vector<Seam> seams = all_seams(full_size() ? 2000 : 500, random);
  check_jumps("weather",
              measure(seams, 20.0, 8, random, weather_values(probe), some_moment, [](std::mt19937&) { return 0.0; }),
              kWeatherNames);
}

TEST_CASE("gpu: density jumps no more over 10 m across the seams than beside them, in every layer") {
  GpuFixture gpu;
  std::mt19937 random(2);
  const CloudParams params = four_layers();
  const Clouds clouds(gpu.device, params);
  CloudProbe probe(gpu.device, clouds);
  const std::vector<Seam> seams = all_seams(full_size() ? 2000 : 500, random);
  const auto values = [&](const Cases& cases) {
    std::vector<std::vector<double>> out;
    for (const CloudProbe::Density& d : probe.density(cases))
      out.push_back({d.density.x, d.density.y, d.density.z, d.density.w});
    return out;
  };
  const auto height = [&](std::mt19937& r) {
    const CloudLayer& l = params.layers[std::uniform_int_distribution<size_t>(0, 3)(r)];
    return l.base_m + l.thickness_m * std::uniform_real_distribution<double>(0.05, 0.4)(r);
  };
  check_jumps("density", measure(seams, 10.0, 4, random, values, some_moment, height, true),
              {"cumulus", "altocumulus", "cirrus", "cumulonimbus"});
}

/// Four channels of waves that tile, 75 km and longer: every seam crosses the tile along few lines only, where steeper
/// waves would not have the slopes that they have 5 km beside.
std::shared_ptr<Raster> wavy_tile(uint32_t side) {
  RasterInfo info;
  info.path = "tile.png";
  info.width = info.height = side;
  info.bands = 4;
  info.bounds = {.west_deg = -1.0, .south_deg = -1.0, .east_deg = 1.0, .north_deg = 1.0};
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<float> values(size_t{side} * side * 4, 0.5f);
  for (int wave = 0; wave < 40; ++wave) {
    const double kx = std::round(8.0 * uniform(random) - 4.0), ky = std::round(8.0 * uniform(random) - 4.0);
    for (size_t band = 0; band < 4; ++band) {
      const double phase = 2.0 * M_PI * uniform(random);
      for (uint32_t y = 0; y < side; ++y)
        for (uint32_t x = 0; x < side; ++x)
          values[4 * (size_t{y} * side + x) + band] +=
              static_cast<float>(0.04 * std::cos(2.0 * M_PI * (kx * x + ky * y) / side + phase));
    }
  }
  return std::make_shared<ArrayRaster>(std::move(info), std::move(values));
}

TEST_CASE("gpu: a local weather texture repeated over the sphere jumps no more at the seams than beside them") {
  GpuFixture gpu;
  std::mt19937 random(3);
  CloudParams params = four_layers();
  params.weather.source = "tile";
  params.weather.file = "tile.png";
  // Without it the antimeridian and the poles are edges of texels, where filters that count in 1/255 (rgba8 on
  // lavapipe) step more often than between.
  params.weather.tile_offset = {0.1382, 0.2917, 0.4431};
  const Clouds clouds(gpu.device, params, {.tile = wavy_tile(128)});
  CloudProbe probe(gpu.device, clouds);
  const std::vector<Seam> seams = all_seams(full_size() ? 2000 : 500, random);
  check_jumps("tile",
              measure(seams, 20.0, 4, random, weather_values(probe), some_moment, [](std::mt19937&) { return 0.0; }),
              {"r", "g", "b", "a"});
}

TEST_CASE("a planted seam of half a usual jump exceeds the limits, none does not") {
  std::mt19937 random(4);
  const std::vector<Seam> seams = {all_seams(500, random).back()};
  for (const double planted : {0.0, 0.5}) {
    const auto values = [&](const Cases& cases) {
      std::vector<std::vector<double>> out;
      for (const CloudProbe::Case& c : cases) {
        // A step is 3.1e-6 of the radius: 0.31 at most.
        const double east = std::sin(c.point.lon_rad);
        out.push_back({std::sin(300.0 * c.point.lat_rad) * 1e5 * east * std::cos(c.point.lat_rad) +
                       (east < 0.0 ? planted * 0.3 : 0.0)});
      }
      return out;
    };
    const auto kinds = measure(seams, 20.0, 1, random, values, some_moment, [](std::mt19937&) { return 0.0; });
    const Jumps& j = kinds[0].channels[0];
    const double ratio = percentile(j.across, 0.99) / percentile(j.beside, 0.99);
    CHECK((ratio > 1.1 + 3.0 * standard_error(j.across, 0.99) / percentile(j.beside, 0.99)) == (planted > 0.0));
  }
}

}  // namespace
}  // namespace nepho::test
