// A satellite's picture of the clouds as weather: does the disc seen from its orbit show the same clouds?
#include <cmath>

#include "gpu/gpu_fixture.h"
#include "rasters/gdal_opener.h"
#include "render/renderer.h"
#include "render/shared_data.h"

using namespace nepho;

namespace {

/// A global raster of cover at one reduction, looked up bilinearly; wraps.
class CoverMap {
 public:
  CoverMap(const Raster& raster, uint32_t reduction) {
    width_ = (raster.info().width + (1u << reduction) - 1u) >> reduction;
    height_ = (raster.info().height + (1u << reduction) - 1u) >> reduction;
    values_.resize(size_t{width_} * height_);
    constexpr uint32_t kSide = Raster::kBlockSize;
    for (uint32_t y0 = 0; y0 < height_; y0 += kSide)
      for (uint32_t x0 = 0; x0 < width_; x0 += kSide) {
        const RasterBlock block = raster.read_block(reduction, x0 / kSide, y0 / kSide).take_or_throw(ErrorKind::input);
        for (uint32_t y = 0; y < block.height; ++y)
          for (uint32_t x = 0; x < block.width; ++x)
            values_[size_t{y0 + y} * width_ + x0 + x] =
                static_cast<double>(block.values[(size_t{y} * block.width + x) * raster.info().bands]);
      }
  }
  double at(double lat_deg, double lon_deg) const {
    const double x = (lon_deg + 180.0) / 360.0 * width_ - 0.5, y = (90.0 - lat_deg) / 180.0 * height_ - 0.5;
    const double fx = x - std::floor(x), fy = y - std::floor(y);
    return (1 - fy) * ((1 - fx) * texel(x, y) + fx * texel(x + 1, y)) +
           fy * ((1 - fx) * texel(x, y + 1) + fx * texel(x + 1, y + 1));
  }

 private:
  double texel(double x, double y) const {
    const auto column = (static_cast<int64_t>(std::floor(x)) + 2 * width_) % width_;
    const auto row = std::clamp<int64_t>(static_cast<int64_t>(std::floor(y)), 0, height_ - 1);
    return values_[static_cast<size_t>(row * width_ + column)];
  }
  uint32_t width_, height_;
  std::vector<double> values_;
};

const std::vector<float>& channel(const ImageBuffer& image, const std::string& name) {
  const ImageChannel* c = image.find(name);
  REQUIRE(c != nullptr);
  return c->values;
}

}  // namespace

TEST_CASE("gpu: from 35,786 km opacity correlates >= 0.9 with the satellite raster that is the weather") {
  const std::string file = shared_data("satellite/nasa_cloud_combined_2048.jpg");
  if (file.empty()) return;
  GpuFixture gpu;
  const std::unique_ptr<RasterOpener> opener = make_gdal_opener();
  const WeatherSources weather{.weather = opener->open_weather(file)};
  const CoverMap fine(*weather.weather, 0), box(*weather.weather, 1);
  for (const double lon_deg : {0.0, -179.5}) {
    Scene scene;
    scene.clouds.multiple_scattering = "octaves";  // how light scatters does not matter
    scene.camera.lat_deg = 0.0;
    scene.camera.lon_deg = lon_deg;
    scene.camera.height_m = 35786e3;
    scene.camera.pitch_deg = -90.0;
    scene.camera.fov_deg = 17.6;
    scene.atmosphere.spectral = "fast";  // nothing here depends on colours
    scene.atmosphere.scattering_orders = 2;
    scene.clouds.weather.source = "raster";
    scene.clouds.weather.file = file;
    for (CloudLayer& layer : scene.clouds.layers) layer.base_reference = "ellipsoid";
    scene.terrain.default_earth = false;
    scene.render.width = scene.render.height = 320;
    Renderer renderer(gpu.device, {}, scene, {}, weather);
    RenderRequest request;
    request.display = false;
    const RenderResult result = renderer.render(request);
    const std::vector<float>&lat = channel(result.layers, "position.lat_deg"),
          &lon = channel(result.layers, "position.lon_deg"), &depth = channel(result.layers, "depth.Z"),
          &clear = channel(result.layers, "cloud.transmittance");
    // The pixel is 39 km wide below the satellite, as two of the raster's.
    double n = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0, point = 0, pp = 0, sp = 0;
    for (size_t i = 0; i < depth.size(); ++i) {
      const double la = rad_from_deg(static_cast<double>(lat[i])),
                   lo = rad_from_deg(static_cast<double>(lon[i]) - lon_deg);
      if (depth[i] > 1e9f || std::acos(std::cos(la) * std::cos(lo)) > rad_from_deg(60.0)) continue;
      const double x = box.at(static_cast<double>(lat[i]), static_cast<double>(lon[i]));
      const double p = fine.at(static_cast<double>(lat[i]), static_cast<double>(lon[i]));
      const double y = 1.0 - static_cast<double>(clear[i]);
      n += 1, sx += x, sy += y, sxx += x * x, syy += y * y, sxy += x * y, point += p, pp += p * p, sp += p * y;
    }
    REQUIRE(n > 20000);
    const auto correlation = [&](double a, double aa, double ab) {
      return (ab / n - a / n * sy / n) / std::sqrt((aa / n - a / n * a / n) * (syy / n - sy / n * sy / n));
    };
    MESSAGE("over " << lon_deg << " degrees east: correlation " << correlation(sx, sxx, sxy) << " with means of 2 x 2, "
                    << correlation(point, pp, sp) << " with single pixels; mean cover " << sx / n << ", mean opacity "
                    << sy / n);
    CHECK(correlation(sx, sxx, sxy) >= 0.9);
    CHECK(std::abs(sy / n - sx / n) < 0.15);  // the slant adds sides
  }
}
