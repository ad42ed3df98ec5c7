#include "rasters/georeference.h"

#include <cpl_string.h>
#include <gdal_alg.h>
#include <gdal_utils.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "base/error.h"
#include "base/log.h"

namespace nepho {

namespace {

using GeoTransform = std::array<double, 6>;  // lon = g0 + g1 column + g2 row, lat = g3 + g4 column + g5 row

constexpr const char* kHowToPlace = "gdal_translate -a_srs EPSG:4326 -a_ullr WEST NORTH EAST SOUTH adds one";

std::optional<GeoTransform> geotransform_of(GDALDataset& dataset) {
  GeoTransform g{};
  if (dataset.GetGeoTransform(g.data()) != CE_None) return std::nullopt;
  const bool identity = g == GeoTransform{0, 1, 0, 0, 0, 1};  // what drivers return for "none"
  const double area = g[1] * g[5] - g[2] * g[4];
  if (identity || !std::isfinite(area) || area == 0.0) return std::nullopt;
  return g;
}

/// Placed by ground control points, a sensor model or arrays of coordinates: GDAL can warp these.
bool placed_by_points(GDALDataset& dataset) {
  return dataset.GetGCPCount() > 0 || dataset.GetMetadata("RPC") != nullptr ||
         dataset.GetMetadata("GEOLOCATION") != nullptr;
}

bool axis_aligned(const GeoTransform& g, int width, int height) {
  constexpr double kSlack = 0.01;  // px over the whole raster
  return std::abs(g[2]) * height < kSlack * std::abs(g[1]) && std::abs(g[4]) * width < kSlack * std::abs(g[5]);
}

bool looks_like_degrees(const GeoTransform& g, int width, int height) {
  const double x0 = std::min(g[0], g[0] + g[1] * width), x1 = std::max(g[0], g[0] + g[1] * width);
  const double y0 = std::min(g[3], g[3] + g[5] * height), y1 = std::max(g[3], g[3] + g[5] * height);
  const double dx = std::abs(g[1]), dy = std::abs(g[5]);
  return axis_aligned(g, width, height) && x0 >= -360.0 - dx && x1 <= 540.0 + dx && x1 - x0 <= 360.0 + 1.5 * dx &&
         y0 >= -90.0 - dy && y1 <= 90.0 + dy;
}

/// Degrees of an axis-aligned geotransform as a grid: west in reach of -180..180, global rasters exactly 360 wide, rows
/// whose centre is beyond a pole left out.
PixelGrid grid_of(const GeoTransform& g, int width, int height) {
  PixelGrid grid;
  grid.flip_x = g[1] < 0.0;
  grid.flip_y = g[5] > 0.0;
  double dx = std::abs(g[1]);
  const double dy = std::abs(g[5]);
  double west = grid.flip_x ? g[0] + g[1] * width : g[0];
  const double north = grid.flip_y ? g[3] + g[5] * height : g[3];

  grid.width = width;
  const int around = static_cast<int>(std::lround(std::min(360.0 / dx, 2e9)));
  if (std::abs(around * dx - 360.0) < 0.5 * dx && width >= around) {
    // Rounded axes (0.0833 for 1/12) drift by a fraction of a pixel around the globe; a repeated last column is
    // dropped.
    const double first_centre = west + 0.5 * dx;
    if (grid.flip_x) grid.x_off = width - around;
    grid.width = around;
    grid.wraps = true;
    dx = 360.0 / around;
    west = first_centre - 0.5 * dx;
  }
  west -= 360.0 * std::floor((west + 0.5 * dx + 180.0) / 360.0);

  constexpr double kPoleSlack = 1e-3;              // px
  const auto rows_beyond = [&](double edge_lat) {  // rows with their centre past the pole, counted from that edge
    return static_cast<int>(std::ceil(std::max(0.0, (edge_lat - 90.0) / dy - 0.5 - kPoleSlack)));
  };
  const int north_cut = std::min(rows_beyond(north), height - 1);
  const int south_cut = std::min(rows_beyond(-(north - dy * height)), height - 1 - north_cut);
  grid.height = height - north_cut - south_cut;
  grid.y_off = grid.flip_y ? south_cut : north_cut;
  grid.bounds.west_deg = west;
  grid.bounds.east_deg = grid.wraps ? west + 360.0 : west + dx * grid.width;
  grid.bounds.north_deg = north - dy * north_cut;
  grid.bounds.south_deg = grid.bounds.north_deg - dy * grid.height;
  return grid;
}

OGRSpatialReference lon_lat_srs() {
  OGRSpatialReference srs;
  srs.importFromEPSG(4326);
  srs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return srs;
}

/// Dataset pixels to longitude and latitude, however the dataset is placed.
class PixelToLonLat {
 public:
  PixelToLonLat(GDALDataset& dataset, bool assume_degrees) {
    CPLStringList options;
    options.SetNameValue("DST_SRS", SRS_WKT_WGS84_LAT_LONG);
    if (assume_degrees) options.SetNameValue("SRC_SRS", SRS_WKT_WGS84_LAT_LONG);
    transformer_ = GDALCreateGenImgProjTransformer2(GDALDataset::ToHandle(&dataset), nullptr, options.List());
  }
  ~PixelToLonLat() {
    if (transformer_) GDALDestroyGenImgProjTransformer(transformer_);
  }
  PixelToLonLat(const PixelToLonLat&) = delete;
  PixelToLonLat& operator=(const PixelToLonLat&) = delete;
  explicit operator bool() const { return transformer_ != nullptr; }
  /// In place; false for a point that has no place.
  bool forward(double& x, double& y) const { return transform(FALSE, x, y); }
  bool inverse(double& x, double& y) const { return transform(TRUE, x, y); }

 private:
  bool transform(int to_pixels, double& x, double& y) const {
    double z = 0.0;
    int good = FALSE;
    GDALGenImgProjTransform(transformer_, to_pixels, 1, &x, &y, &z, &good);
    return good && std::isfinite(x) && std::isfinite(y);
  }
  void* transformer_ = nullptr;
};

double wrapped_degrees(double difference) { return std::remainder(difference, 360.0); }

/// A geographic CRS of another name or datum whose coordinates are those of EPSG:4326 to a hundredth of a pixel.
bool same_as_lon_lat(GDALDataset& dataset, const GeoTransform& g) {
  const PixelToLonLat lon_lat_from_pixel(dataset, false);
  if (!lon_lat_from_pixel) return false;
  constexpr double kSlack = 0.01;  // px
  for (const double u : {0.01, 0.5, 0.99})
    for (const double v : {0.01, 0.5, 0.99}) {
      double x = u * dataset.GetRasterXSize(), y = v * dataset.GetRasterYSize();
      const double lon = g[0] + g[1] * x, lat = g[3] + g[5] * y;
      if (std::abs(lat) > 90.0) continue;
      if (!lon_lat_from_pixel.forward(x, y)) return false;
      if (std::abs(wrapped_degrees(x - lon)) > kSlack * std::abs(g[1]) || std::abs(y - lat) > kSlack * std::abs(g[5]))
        return false;
    }
  return true;
}

std::string name_of(const OGRSpatialReference& srs) {
  const char* name = srs.GetName();
  return name ? name : "unnamed";
}

void require_earth_crs(const OGRSpatialReference& srs, const std::string& path) {
  if (!srs.IsGeographic() && !srs.IsProjected() && !srs.IsDerivedGeographic())
    throw fail(ErrorKind::input,
               "{}: its CRS '{}' is not a place on the Earth; give a geographic or projected CRS ({})", path,
               name_of(srs), "gdal_translate -a_srs EPSG:CODE");
}

bool gcps_in_degrees(GDALDataset& dataset) {
  const GDAL_GCP* points = dataset.GetGCPs();
  return std::all_of(points, points + dataset.GetGCPCount(),
                     [](const GDAL_GCP& p) { return std::abs(p.dfGCPX) <= 540.0 && std::abs(p.dfGCPY) <= 90.0; });
}

bool needs_assumed_degrees(GDALDataset& dataset) {
  return dataset.GetGCPCount() > 0 && !dataset.GetGCPSpatialRef() && !dataset.GetSpatialRef();
}

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

}  // namespace

std::optional<PixelGrid> native_grid(GDALDataset& dataset, const std::string& path, const GdalMessages& messages) {
  const int width = dataset.GetRasterXSize(), height = dataset.GetRasterYSize();
  const auto g = geotransform_of(dataset);
  const OGRSpatialReference* srs = dataset.GetSpatialRef();
  const bool broken =
      messages.has_error() && (srs ? srs->IsEmpty() : g.has_value());  // there was text, but OGR could not read it
  if (srs && srs->IsEmpty()) srs = nullptr;
  if (g && srs) {
    require_earth_crs(*srs, path);
    if (!srs->IsGeographic() || !axis_aligned(*g, width, height)) return std::nullopt;
    const char* const loosely[] = {"IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES",
                                   "CRITERION=EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS", nullptr};
    const OGRSpatialReference wanted = lon_lat_srs();
    if (srs->IsSame(&wanted, loosely) || same_as_lon_lat(dataset, *g)) return grid_of(*g, width, height);
    return std::nullopt;
  }
  if (broken || (!srs && !messages.crs_complaint().empty()))
    throw fail(ErrorKind::input,
               "{}: its CRS is not one that PROJ knows{}; gdal_translate -a_srs EPSG:CODE gives another", path,
               broken ? messages.in_brackets() : messages.crs_complaint());
  if (g) {
    if (looks_like_degrees(*g, width, height)) return grid_of(*g, width, height);
    throw fail(ErrorKind::input,
               "{}: has no CRS, and its coordinates ({:.9g} {:.9g}, pixel {:.9g} x {:.9g}) are not degrees; "
               "gdal_translate -a_srs EPSG:CODE adds one",
               path, (*g)[0], (*g)[3], (*g)[1], (*g)[5]);
  }
  if (placed_by_points(dataset)) {
    if (needs_assumed_degrees(dataset) && !gcps_in_degrees(dataset))
      throw fail(ErrorKind::input,
                 "{}: has control points without a CRS that are not degrees; gdal_translate -a_srs EPSG:CODE adds one",
                 path);
    return std::nullopt;
  }
  if (srs) require_earth_crs(*srs, path);
  if ((srs && !srs->IsGeographic()) || int64_t{width} != 2 * int64_t{height})
    throw fail(ErrorKind::input,
               "{}: {} x {} pixels without georeference (only a global picture of exactly 2:1 needs none); {}", path,
               width, height, kHowToPlace);
  PixelGrid grid = grid_of({-180.0, 360.0 / width, 0.0, 90.0, 0.0, -180.0 / height}, width, height);
  grid.assumed_global = true;
  return grid;
}

VerticalDatum vertical_datum(GDALDataset& dataset, const std::string& path) {
  const OGRSpatialReference* srs = dataset.GetSpatialRef();
  if (!srs || srs->IsEmpty()) return VerticalDatum::egm96;
  if (!srs->IsCompound()) return srs->GetAxesCount() == 3 ? VerticalDatum::ellipsoid : VerticalDatum::egm96;
  const char* node = srs->GetAttrValue("VERT_CS");
  const char* type = srs->GetAttrValue("VERT_DATUM", 1);
  const std::string name = node ? node : "";
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if ((type && std::string(type) == "2002") || lower.find("ellips") != std::string::npos)
    return VerticalDatum::ellipsoid;
  if (lower.find("egm96") == std::string::npos && lower.find("msl") == std::string::npos &&
      lower.find("mean sea level") == std::string::npos)
    log_warning("{}: heights above '{}' are taken as heights above EGM96 mean sea level", path, name);
  return VerticalDatum::egm96;
}

namespace {

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
               source.GetSpatialRef() ? name_of(*source.GetSpatialRef()) : "none", messages.in_brackets());

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
