#include "rasters/default_earth.h"

#include <filesystem>

namespace nepho {
namespace fs = std::filesystem;

namespace {
std::string find_shared(const char* relative) {
  std::error_code ignored;
  for (const char* root : {"/usr/local/share", "/usr/share"}) {
    const fs::path path = fs::path(root) / relative;
    if (fs::is_regular_file(path, ignored)) return path.string();
  }
  return {};
}
}  // namespace

DefaultEarth find_default_earth() {
  DefaultEarth earth;
  earth.imagery = find_shared("marble/data/maps/earth/bluemarble/bluemarble.jpg");
  earth.night = find_shared("xplanet/images/night.jpg");
  earth.moon = find_shared("marble/data/maps/moon/clementine/clementine.jpg");
  earth.stars = find_shared("marble/data/stars/stars.dat");
  const std::string etopo = find_shared("ferret-vis/data/etopo5.cdf");
  if (!etopo.empty()) earth.elevation = "NETCDF:\"" + etopo + "\":ROSE";
  return earth;
}

bool is_default_earth_file(const std::string& path) {
  const DefaultEarth earth = find_default_earth();
  return !path.empty() &&
         (path == earth.elevation || path == earth.imagery || path == earth.night || path == earth.moon);
}

}  // namespace nepho
