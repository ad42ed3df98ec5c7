#include <cmath>
#include <limits>
#include <optional>

#include "astro/utc_time.h"
#include "clouds/cloud_probe.h"
#include "gpu/device.h"
#include "probe_tables.h"

namespace nepho {

namespace {

using Case = CloudProbe::Case;
using Type = ProbeInput::Type;

constexpr double kLowest_m = -12000.0, kHighest_m = 1e9;  // as cameras of scenes
constexpr double kWidestFootprint_m = 1e7;
constexpr double kColumnFootprint_m = 10.0;
constexpr const char* kChannels[] = {"r", "g", "b", "a"};

/// The rows of a table as cases, checked.
class CloudTable {
 public:
  CloudTable(const ProbeTable& in, const Scene& scene, double default_footprint_m)
      : in_(in), scene_time_s_(parse_utc(scene.time).seconds_since_2000()), default_footprint_m_(default_footprint_m) {}

  std::vector<Case> cases() {
    std::vector<Case> all;
    all.reserve(in_.rows());
    for (size_t row = 0; row < in_.rows(); ++row) all.push_back(make_case(row));
    return all;
  }

 private:
  Case make_case(size_t row) {
    Case c;
    c.point = place(row, "");
    if (const double lat = number(row, "camera_lat_deg"); !std::isnan(lat)) c.camera = place(row, "camera_");
    c.time_s = time_s(row);
    c.footprint_m = footprint_m(row);
    return c;
  }
  Geodetic place(size_t row, const std::string& prefix) const {
    const double height_m = within(row, prefix + "height_m", kLowest_m, kHighest_m);
    return Geodetic::from_degrees(number(row, prefix + "lat_deg"), number(row, prefix + "lon_deg"),
                                  std::isnan(height_m) ? 0.0 : height_m);
  }
  double footprint_m(size_t row) const {
    const double footprint = within(row, "footprint_m", 0.0, kWidestFootprint_m);
    return std::isnan(footprint) ? default_footprint_m_ : footprint;
  }
  double time_s(size_t row) {
    if (!in_.given("time") || in_.texts("time")[row].empty()) return scene_time_s_;
    const std::string& text = in_.texts("time")[row];
    if (text == last_time_) return last_time_s_;  // tables of one moment, row after row
    try {
      last_time_s_ = parse_utc(text).seconds_since_2000();
    } catch (const Error& e) {
      throw in_.bad_cell(row, "time", e.what());
    }
    last_time_ = text;
    return last_time_s_;
  }
  /// NaN without the column or where it is blank.
  double number(size_t row, const std::string& column) const {
    return in_.given(column) ? in_.numbers(column)[row] : std::numeric_limits<double>::quiet_NaN();
  }
  double within(size_t row, const std::string& column, double low, double high) const {
    const double value = number(row, column);
    if (value < low || value > high)
      throw in_.bad_cell(row, column, fmt::format("{} is outside {}..{}", value, low, high));
    return value;
  }

  const ProbeTable& in_;
  double scene_time_s_, default_footprint_m_;
  std::string last_time_;
  double last_time_s_ = 0.0;
};

/// Columns NAME_r, _g, _b, _a of four values.
template <typename Answer>
void add_channels(std::vector<ProbeColumn>& columns, const std::string& name, const std::vector<Answer>& answers,
                  glm::vec4 Answer::*values) {
  for (int i = 0; i < 4; ++i) {
    ProbeColumn column{fmt::format("{}_{}", name, kChannels[i]), {}};
    column.values.reserve(answers.size());
    for (const Answer& answer : answers) column.values.push_back(static_cast<double>((answer.*values)[i]));
    columns.push_back(std::move(column));
  }
}

template <typename Answer>
void add(std::vector<ProbeColumn>& columns, const std::string& name, const std::vector<Answer>& answers,
         float Answer::*value) {
  ProbeColumn column{name, {}};
  column.values.reserve(answers.size());
  for (const Answer& answer : answers) column.values.push_back(static_cast<double>(answer.*value));
  columns.push_back(std::move(column));
}

std::vector<ProbeColumn> columns_of(const std::vector<CloudProbe::Weather>& answers) {
  std::vector<ProbeColumn> columns;
  add_channels(columns, "coverage", answers, &CloudProbe::Weather::coverage);
  add(columns, "type", answers, &CloudProbe::Weather::type);
  add(columns, "base_offset_m", answers, &CloudProbe::Weather::base_offset_m);
  add(columns, "density_factor", answers, &CloudProbe::Weather::density_factor);
  add(columns, "precipitation", answers, &CloudProbe::Weather::precipitation);
  return columns;
}

std::vector<ProbeColumn> columns_of(const std::vector<CloudProbe::Density>& answers) {
  std::vector<ProbeColumn> columns;
  add_channels(columns, "density", answers, &CloudProbe::Density::density);
  add(columns, "extinction_per_m", answers, &CloudProbe::Density::extinction_per_m);
  return columns;
}

std::vector<ProbeColumn> columns_of(const std::vector<CloudProbe::Column>& answers) {
  std::vector<ProbeColumn> columns;
  add_channels(columns, "optical_depth", answers, &CloudProbe::Column::optical_depth);
  ProbeColumn total{"optical_depth", {}};
  for (size_t row = 0; row < answers.size(); ++row) {
    double sum = 0.0;
    for (size_t i = 0; i < 4; ++i) sum += columns[i].values[row];
    total.values.push_back(sum);
  }
  columns.push_back(std::move(total));
  add(columns, "base_m", answers, &CloudProbe::Column::base_m);
  add(columns, "top_m", answers, &CloudProbe::Column::top_m);
  return columns;
}

void require_numbers(const ProbeTable& in, const std::vector<ProbeColumn>& columns) {
  for (const ProbeColumn& column : columns) {
    const bool may_be_blank = column.name == "base_m" || column.name == "top_m";
    for (size_t row = 0; row < column.values.size(); ++row)
      if (!std::isfinite(column.values[row]) && !(may_be_blank && std::isnan(column.values[row])))
        throw fail(ErrorKind::failure, "{} is {}: please report it", in.bad_cell(row, column.name, "the result").what(),
                   column.values[row]);
  }
}

template <typename Answer>
ProbeKind cloud_kind(const std::string& name, std::vector<ProbeInput> inputs, double default_footprint_m,
                     std::vector<Answer> (CloudProbe::*ask)(const std::vector<Case>&)) {
  const auto evaluate = [=](const ProbeTable& in, const ProbeOptions& options) {
    const std::vector<Case> cases = CloudTable(in, options.scene, default_footprint_m).cases();
    std::vector<Answer> answers;
    if (!cases.empty()) {
      // Bad files are told before a device is asked for.
      const WeatherSources sources = options.open_weather ? options.open_weather(options.scene) : WeatherSources{};
      gpu::Device device({.device = options.device});
      const Clouds clouds(device, options.scene.clouds, sources);
      answers = (CloudProbe(device, clouds).*ask)(cases);
    }
    const std::vector<ProbeColumn> columns = columns_of(answers);
    require_numbers(in, columns);
    return columns;
  };
  return {name, std::move(inputs), evaluate};
}

}  // namespace

std::vector<ProbeKind> cloud_probe_kinds() {
  std::vector<ProbeInput> vertical{{"lat_deg", Type::latitude_deg},
                                   {"lon_deg"},
                                   {"footprint_m", Type::number, "footprint"},
                                   {"time", Type::text, "time"},
                                   {"camera_lat_deg", Type::latitude_deg, "camera"},
                                   {"camera_lon_deg", Type::number, "camera"},
                                   {"camera_height_m", Type::number, "camera"}};
  std::vector<ProbeInput> points = vertical;
  points.insert(points.begin() + 2, {"height_m"});
  return {cloud_kind("weather", vertical, 0.0, &CloudProbe::weather),
          cloud_kind("density", points, 0.0, &CloudProbe::density),
          cloud_kind("column", vertical, kColumnFootprint_m, &CloudProbe::column)};
}

}  // namespace nepho
