#include "nepho/raster_access.h"

#include "base/error.h"

namespace nepho {

namespace {

class RefusingOpener final : public RasterOpener {
 public:
  std::shared_ptr<Raster> open_elevation(const std::string& path, const RasterReading&) const override { refuse(path); }
  std::shared_ptr<Raster> open_imagery(const std::string& path, const RasterReading&) const override { refuse(path); }
  std::shared_ptr<Raster> open_weather(const std::string& path) const override { refuse(path); }
  std::shared_ptr<Raster> open_tile(const std::string& path) const override { refuse(path); }

 private:
  [[noreturn]] static void refuse(const std::string& path) {
    throw fail(ErrorKind::input, "{}: this build has no GDAL and reads no rasters; use nepho instead of nepho_portable",
               path);
  }
};

}  // namespace

RasterAccess no_rasters() {
  return {.opener = std::make_shared<RefusingOpener>(),
          .find_default_earth = [] { return DefaultEarth{}; },
          .gdal_version = ""};
}

}  // namespace nepho
