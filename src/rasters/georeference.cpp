#include "rasters/georeference.h"

#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "base/log.h"
#include "rasters/pixel_to_lon_lat.h"

namespace nepho {

namespace {

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

OGRSpatialReference lon_lat_srs() {
  OGRSpatialReference srs;
  srs.importFromEPSG(4326);
  srs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return srs;
}

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

void require_earth_crs(const OGRSpatialReference& srs, const std::string& path) {
  if (!srs.IsGeographic() && !srs.IsProjected() && !srs.IsDerivedGeographic())
    throw fail(ErrorKind::input,
               "{}: its CRS '{}' is not a place on the Earth; give a geographic or projected CRS ({})", path,
               crs_name(srs), "gdal_translate -a_srs EPSG:CODE");
}

bool gcps_in_degrees(GDALDataset& dataset) {
  const GDAL_GCP* points = dataset.GetGCPs();
  return std::all_of(points, points + dataset.GetGCPCount(),
                     [](const GDAL_GCP& p) { return std::abs(p.dfGCPX) <= 540.0 && std::abs(p.dfGCPY) <= 90.0; });
}

}  // namespace

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

}  // namespace nepho
