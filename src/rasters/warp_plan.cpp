#include "rasters/warp_plan.h"

#include <cpl_string.h>
#include <gdal_utils.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "base/error.h"
#include "rasters/pixel_to_lon_lat.h"

namespace nepho {

namespace {

/// Where a dataset lies: found by sampling it on a lattice.
struct Footprint {
  double west = 0, east = 0, south = 0, north = 0;  // degrees; east may pass 180
  bool global = false;
  double lon_step = 0, lat_step = 0;  // degrees per source pixel
};

/// The smallest arc that holds all longitudes; the whole circle when no gap is wider than `gap`.
void longitude_extent(std::vector<double> lons, double gap, Footprint& f) {
  for (double& lon : lons) lon = wrapped_degrees(lon);
  std::sort(lons.begin(), lons.end());
  double widest = lons.front() + 360.0 - lons.back();
  f.west = lons.front();
  f.east = lons.back();
  for (size_t i = 1; i < lons.size(); ++i)
    if (lons[i] - lons[i - 1] > widest) {
      widest = lons[i] - lons[i - 1];
      f.west = lons[i];
      f.east = lons[i - 1] + 360.0;
    }
  if (widest > gap) return;
  f.global = true;
  f.west = -180.0;
  f.east = 180.0;
}

std::optional<Footprint> footprint_of(GDALDataset& dataset, const PixelToLonLat& lon_lat_from_pixel) {
  constexpr int kCells = 128;
  const double width = dataset.GetRasterXSize(), height = dataset.GetRasterYSize();
  struct Point {
    double lon, lat;
    bool good;
  };
  std::vector<Point> points(size_t{kCells + 1} * (kCells + 1));
  std::vector<double> lons, lon_steps, lat_steps;
  Footprint f{.south = 90.0, .north = -90.0};
  const auto at = [&](int i, int j) -> Point& { return points[static_cast<size_t>(j * (kCells + 1) + i)]; };
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      double x = width * i / kCells, y = height * j / kCells;
      const bool good = lon_lat_from_pixel.forward(x, y) && std::abs(y) <= 90.0;
      at(i, j) = {x, y, good};
      if (!good) continue;
      lons.push_back(x);
      f.south = std::min(f.south, y);
      f.north = std::max(f.north, y);
    }
  if (lons.size() < 4) return std::nullopt;
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      const Point p = at(i, j), right = at(i + 1, j), below = at(i, j + 1);
      if (!p.good || !right.good || !below.good) continue;
      const double across = width / kCells, down = height / kCells;  // px between points
      lon_steps.push_back(
          std::hypot(wrapped_degrees(right.lon - p.lon) / across, wrapped_degrees(below.lon - p.lon) / down));
      lat_steps.push_back(std::hypot((right.lat - p.lat) / across, (below.lat - p.lat) / down));
    }
  if (lon_steps.empty()) return std::nullopt;
  // The finest longitude step is the one nearest the equator; latitude steps differ much in Mercator only.
  std::sort(lon_steps.begin(), lon_steps.end());
  std::sort(lat_steps.begin(), lat_steps.end());
  f.lon_step = lon_steps[lon_steps.size() / 50];
  f.lat_step = lat_steps[lat_steps.size() / 2];

  bool pole_inside = false;
  for (const double pole : {90.0, -90.0}) {
    double x = 0.0, y = pole;
    if (!lon_lat_from_pixel.inverse(x, y) || x < 0.0 || y < 0.0 || x > width || y > height) continue;
    if (!lon_lat_from_pixel.forward(x, y) || std::abs(y - pole) > 0.01) continue;  // a projection far from its home
    (pole > 0 ? f.north : f.south) = pole;
    pole_inside = true;
  }
  longitude_extent(std::move(lons), pole_inside ? 360.0 : 2.5 * 360.0 / kCells, f);
  if (!(f.lon_step > 0.0 && f.lat_step > 0.0 && f.east > f.west && f.north > f.south)) return std::nullopt;
  return f;
}

/// Levels of half the resolution each that an overview of the source suits, neither finer than its pixels nor much
/// coarser, so that far looks read no more than they show.
/// Those above 0 that are still finer than the source, or as fine, come from its own pixels.
std::vector<WarpPlan::Level> warp_levels(GDALDataset& source, int width, int height, uint32_t finer_levels) {
  std::vector<WarpPlan::Level> levels = {{}};
  GDALRasterBand& band = *source.GetRasterBand(1);
  constexpr int kSmall = 256;  // px
  for (uint32_t k = 1; k < 31 && (std::max(width, height) >> (k - 1)) > kSmall; ++k) {
    WarpPlan::Level level{.level = k};
    if (k <= finer_levels) {
      levels.push_back(level);
      continue;
    }
    const double wanted = std::ldexp(1.0, static_cast<int>(k - finer_levels));
    double best = 0.0;
    for (int i = 0; i < band.GetOverviewCount(); ++i) {
      GDALRasterBand* overview = band.GetOverview(i);
      if (!overview || overview->GetXSize() < 1) continue;
      const double ratio = double(band.GetXSize()) / overview->GetXSize();
      if (ratio > 1.1 * wanted || ratio < 0.6 * wanted || ratio < best) continue;
      best = ratio;
      level.overview = i;
    }
    if (level.overview >= 0) levels.push_back(level);
  }
  return levels;
}

}  // namespace

WarpPlan plan_warp(GDALDataset& source, const std::string& path, bool elevation, double alpha_max,
                   const GdalMessages& messages, bool alpha_is_data, uint32_t finer_levels) {
  const bool assume_degrees = needs_assumed_degrees(source);
  const PixelToLonLat lon_lat_from_pixel(source, assume_degrees);
  const auto f = lon_lat_from_pixel ? footprint_of(source, lon_lat_from_pixel) : std::nullopt;
  if (!f)
    throw fail(ErrorKind::input,
               "{}: its CRS '{}' cannot be brought to longitude and latitude{}; give one that PROJ knows", path,
               source.GetSpatialRef() ? crs_name(*source.GetSpatialRef()) : "none", messages.in_brackets());

  // The same number of pixels per degree, but never many times the source's pixels (a pole stretches a row without
  // end).
  constexpr double kMostPixels = 8.0;
  const double source_pixels = double(source.GetRasterXSize()) * source.GetRasterYSize();
  const double wanted = (f->east - f->west) / f->lon_step * ((f->north - f->south) / f->lat_step);
  const double limited = std::max(1.0, std::sqrt(wanted / (kMostPixels * source_pixels + 1e6)));
  // Numbers of pixels are ints to GDAL.
  while (finer_levels > 0 && std::ldexp((f->east - f->west) / f->lon_step, static_cast<int>(finer_levels)) > 0x1p30)
    --finer_levels;
  const double coarser = std::ldexp(limited, -static_cast<int>(finer_levels));
  // Rounding in the steps must not add a pixel, or, with overviews, a row of the coarsest level's.
  const auto pixels = [&](double extent, double step) {
    const double count = extent / (step * coarser);
    return std::max(1, static_cast<int>(std::ceil(count - std::max(1e-6, 1e-6 * count))));
  };
  int width = pixels(f->east - f->west, f->lon_step), height = pixels(f->north - f->south, f->lat_step);
  WarpPlan plan;
  plan.levels = warp_levels(source, width, height, finer_levels);
  const uint32_t halvings = plan.levels.back().level;
  width = static_cast<int>(((static_cast<int64_t>(width) - 1) >> halvings) + 1) << halvings;
  height = static_cast<int>(((static_cast<int64_t>(height) - 1) >> halvings) + 1) << halvings;
  const double lon_step = f->global || halvings > 0 ? (f->east - f->west) / width : f->lon_step * coarser;
  const double lat_step = (f->north - f->south) / height;
  const double east = f->global ? 180.0 : f->west + lon_step * width;

  const auto add = [&](std::initializer_list<std::string> words) {
    plan.args.insert(plan.args.end(), words.begin(), words.end());
  };
  const auto degrees = [](double v) { return fmt::format("{:.17g}", v); };
  add({"-of", "VRT", "-q", "-t_srs", "EPSG:4326", "-r", "bilinear", "-et", "0.05", "-wo", "UNIFIED_SRC_NODATA=YES"});
  add({"-te", degrees(f->west), degrees(f->south), degrees(east), degrees(f->north)});
  if (assume_degrees) add({"-s_srs", "EPSG:4326"});
  if (elevation) {
    add({"-ot", "Float32", "-dstnodata", "nan", "-novshift"});
    GDALRasterBand& band = *source.GetRasterBand(1);
    int has_nodata = FALSE;
    band.GetNoDataValue(&has_nodata);
    // The void of 16-bit elevation even where the file does not say so: it must not be blended with its neighbours.
    if (!has_nodata && band.GetRasterDataType() == GDT_Int16) add({"-srcnodata", "-32768"});
  } else {
    const std::string most = fmt::format("{:g}", alpha_max);
    add({"-dstalpha", "-wo", "SRC_ALPHA_MAX=" + most, "-wo", "DST_ALPHA_MAX=" + most});
    if (alpha_is_data) add({"-nosrcalpha"});
  }
  plan.width = width;
  plan.height = height;
  plan.grid = grid_of({f->west, lon_step, 0.0, f->north, 0.0, -lat_step}, width, height);
  plan.finer_levels = finer_levels;
  return plan;
}

GDALDatasetUniquePtr warp(GDALDataset& source, const WarpPlan& plan, const WarpPlan::Level& level,
                          const std::string& path, const GdalMessages& messages) {
  CPLStringList args;
  for (const std::string& word : plan.args) args.AddString(word.c_str());
  const auto reduced = [&](int size) { return std::to_string(std::max(1, size >> level.level)); };
  for (const std::string& word : {std::string("-ts"), reduced(plan.width), reduced(plan.height), std::string("-ovr"),
                                  level.overview < 0 ? std::string("NONE") : std::to_string(level.overview)})
    args.AddString(word.c_str());
  std::unique_ptr<GDALWarpAppOptions, decltype(&GDALWarpAppOptionsFree)> options(
      GDALWarpAppOptionsNew(args.List(), nullptr), &GDALWarpAppOptionsFree);
  GDALDatasetH handles[] = {GDALDataset::ToHandle(&source)};
  int misuse = FALSE;
  GDALDatasetUniquePtr warped;
  if (options) warped.reset(GDALDataset::FromHandle(GDALWarp("", nullptr, 1, handles, options.get(), &misuse)));
  if (!warped) throw fail(ErrorKind::input, "{}: cannot be warped to EPSG:4326{}", path, messages.in_brackets());
  return warped;
}

}  // namespace nepho
