#include "nepho/raster_access.h"

#include <filesystem>

#include "base/error.h"
#include "base/files.h"
#include "terrain/baked_raster.h"

namespace nepho {

namespace {

/// Opens the baked default Earth; every other raster is an Error(input).
class BakedOpener final : public RasterOpener {
 public:
  std::shared_ptr<Raster> open_elevation(const std::string& path, const RasterReading&) const override {
    if (path == find_baked_earth().elevation) return open_baked_raster(path);
    refuse(path);
  }
  std::shared_ptr<Raster> open_imagery(const std::string& path, const RasterReading&) const override {
    const DefaultEarth earth = find_baked_earth();
    if (!path.empty() && (path == earth.imagery || path == earth.night || path == earth.moon))
      return open_baked_raster(path);
    refuse(path);
  }
  std::shared_ptr<Raster> open_weather(const std::string& path) const override { refuse(path); }
  std::shared_ptr<Raster> open_tile(const std::string& path) const override { refuse(path); }

 private:
  [[noreturn]] static void refuse(const std::string& path) {
    throw fail(ErrorKind::input,
               "{}: this build has no GDAL and reads no rasters but its own Earth; use nepho instead of nepho_portable",
               path);
  }
};

}  // namespace

DefaultEarth find_baked_earth() {
  const std::filesystem::path folder = data_dir() / "earth";
  const auto find = [&](const char* name) {
    std::error_code ignored;
    return std::filesystem::is_regular_file(folder / name, ignored) ? (folder / name).string() : std::string{};
  };
  return {.elevation = find("elevation.baked"),
          .imagery = find("imagery.baked"),
          .night = find("night.baked"),
          .moon = find("moon.baked"),
          .stars = find("stars.dat")};
}

RasterAccess baked_rasters() {
  return {.opener = std::make_shared<BakedOpener>(), .find_default_earth = find_baked_earth, .gdal_version = ""};
}

}  // namespace nepho
