#include "nepho/cmd_info.h"

#include <GeographicLib/Config.h>
#include <OpenEXRConfig.h>
#include <erfa.h>
#include <erfaextra.h>
#include <fmt/format.h>
#include <png.h>
#include <spdlog/version.h>
#include <vulkan/vulkan_core.h>

#include <CLI/Version.hpp>
#include <nlohmann/json.hpp>
#include <ostream>

#include "base/files.h"
#include "geo/geoid.h"
#include "gpu/device.h"
#include "nepho/raster_access.h"
#include "scene/cloud_params.h"
#include "scene/places.h"

namespace nepho {

namespace {

using Json = nlohmann::ordered_json;
using Table = std::vector<std::pair<std::string, std::string>>;

/// Data that the program uses when it is there; empty paths are missing.
Table find_data(const RasterAccess& rasters) {
  const DefaultEarth earth = rasters.find_default_earth();
  return {{"elevation", earth.elevation}, {"imagery", earth.imagery},     {"night", earth.night},
          {"moon", earth.moon},           {"stars", earth.stars},         {"geoid_egm96", Geoid::find_egm96().string()},
          {"data", data_dir().string()},  {"cache", cache_dir().string()}};
}

/// The Debian package that brings a missing piece of data.
std::string package_of(const std::string& data, const RasterAccess& rasters) {
  const bool is_earth =
      data == "elevation" || data == "imagery" || data == "moon" || data == "stars" || data == "night";
  if (is_earth && !rasters.has_gdal()) return "missing: ./nepho package makes a folder with it";
  if (data == "elevation") return "missing: apt-get install ferret-datasets";
  if (data == "imagery" || data == "moon" || data == "stars") return "missing: apt-get install marble-qt-data";
  if (data == "night") return "missing: apt-get install xplanet-images";
  if (data == "geoid_egm96") return "missing: apt-get install proj-data";
  return "none: no folder could be made; set NEPHO_CACHE";
}

Table library_versions(const RasterAccess& rasters) {
  return {{"Vulkan headers", fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(VK_HEADER_VERSION_COMPLETE),
                                         VK_API_VERSION_MINOR(VK_HEADER_VERSION_COMPLETE), VK_HEADER_VERSION)},
          {"GDAL", rasters.has_gdal() ? rasters.gdal_version : "none: reads the baked Earth only"},
          {"GeographicLib", GEOGRAPHICLIB_VERSION_STRING},
          {"ERFA", eraVersion()},
          {"OpenEXR", OPENEXR_VERSION_STRING},
          {"libpng", PNG_LIBPNG_VER_STRING},
          {"CLI11", CLI11_VERSION},
          {"nlohmann-json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                                        NLOHMANN_JSON_VERSION_PATCH)},
          {"fmt", fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100)},
          {"spdlog", fmt::format("{}.{}.{}", SPDLOG_VER_MAJOR, SPDLOG_VER_MINOR, SPDLOG_VER_PATCH)}};
}

Json json_info(const RasterAccess& rasters) {
  Json info{{"version", NEPHO_VERSION}, {"devices", Json::array()}};
  for (const gpu::DeviceInfo& device : gpu::list_devices())
    info["devices"].push_back({{"index", device.index},
                               {"name", device.name},
                               {"driver", device.driver},
                               {"api_version", device.api_version},
                               {"is_software", device.is_software},
                               {"usable", device.usable},
                               {"why_not", device.why_not}});
  for (const auto& [name, path] : find_data(rasters)) info["data"][name] = path.empty() ? Json(nullptr) : Json(path);
  for (const Place& place : named_places()) info["places"][place.name] = place.title;
  info["skies"] = cloud_sky_names();
  for (const auto& [name, version] : library_versions(rasters)) info["libraries"][name] = version;
  return info;
}

void print_text(std::ostream& out, const RasterAccess& rasters) {
  out << "nepho " NEPHO_VERSION "\n\nVulkan devices\n";
  const std::vector<gpu::DeviceInfo> devices = gpu::list_devices();
  if (devices.empty()) out << "  none: no Vulkan driver; apt-get install mesa-vulkan-drivers\n";
  for (const gpu::DeviceInfo& device : devices)
    out << fmt::format("  {}  {}, {}, Vulkan {}{}{}\n", device.index, device.name, device.driver, device.api_version,
                       device.is_software ? ", software" : "",
                       device.usable ? "" : fmt::format(", not usable: {}", device.why_not));
  out << "\nData\n";
  for (const auto& [name, path] : find_data(rasters))
    out << fmt::format("  {:14} {}\n", name, path.empty() ? package_of(name, rasters) : path);
  out << "\nPlaces\n";
  for (const Place& place : named_places()) out << fmt::format("  {:14} {}\n", place.name, place.title);
  out << fmt::format("\nSkies\n  {}\n", fmt::join(cloud_sky_names(), ", "));
  out << "\nLibraries\n";
  for (const auto& [name, version] : library_versions(rasters)) out << fmt::format("  {:14} {}\n", name, version);
}

}  // namespace

void print_info(bool as_json, std::ostream& out, const RasterAccess& rasters) {
  if (as_json)
    out << json_info(rasters).dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  else
    print_text(out, rasters);
}

}  // namespace nepho
