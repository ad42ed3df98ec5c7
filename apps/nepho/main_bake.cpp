// nepho_bake FOLDER: the default Earth of this machine as files that nepho_portable reads without GDAL.
#include <cstdio>
#include <exception>
#include <filesystem>

#include "base/error.h"
#include "geo/geoid.h"
#include "rasters/default_earth.h"
#include "rasters/gdal_opener.h"
#include "terrain/baked_raster.h"

namespace {

namespace fs = std::filesystem;

void copy_into(const fs::path& folder, const fs::path& file) {
  std::error_code ec;
  fs::copy_file(file, folder / file.filename(), fs::copy_options::overwrite_existing, ec);
  if (ec) throw nepho::fail(nepho::ErrorKind::failure, "{}: cannot be copied ({})", file.string(), ec.message());
}

/// Names the packages whose data are missing: a package without them would be a poor surprise elsewhere.
void require_all(const nepho::DefaultEarth& earth, const fs::path& geoid) {
  for (const auto& [what, package] : {std::pair{earth.elevation, "ferret-datasets"},
                                      {earth.imagery, "marble-qt-data"},
                                      {earth.moon, "marble-qt-data"},
                                      {earth.stars, "marble-qt-data"},
                                      {earth.night, "xplanet-images"},
                                      {geoid.string(), "proj-data"}})
    if (what.empty())
      throw nepho::fail(nepho::ErrorKind::input, "part of the default Earth is not installed: {}", package);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: nepho_bake FOLDER\n", stderr);
    return 2;
  }
  try {
    const fs::path folder = argv[1], geoid = nepho::Geoid::find_egm96();
    const nepho::DefaultEarth earth = nepho::find_default_earth();
    require_all(earth, geoid);
    fs::create_directories(folder);
    const auto opener = nepho::make_gdal_opener();
    nepho::bake_raster(*opener->open_elevation(earth.elevation, {}), folder / "elevation.baked");
    nepho::bake_raster(*opener->open_imagery(earth.imagery, {}), folder / "imagery.baked");
    nepho::bake_raster(*opener->open_imagery(earth.night, {}), folder / "night.baked");
    nepho::bake_raster(*opener->open_imagery(earth.moon, {}), folder / "moon.baked");
    copy_into(folder, earth.stars);
    copy_into(folder, geoid);
    return 0;
  } catch (const nepho::Error& e) {
    std::fprintf(stderr, "nepho_bake: %s\n", e.what());
    return e.exit_status();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "nepho_bake: %s\n", e.what());
    return 5;
  }
}
