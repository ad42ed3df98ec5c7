// Every raster of the shared data, given by its path alone, is drawn in the right place and in its own colours.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>

#include "gpu/gpu_fixture.h"
#include "nepho/scene_sources.h"
#include "rasters/gdal_opener.h"
#include "render/gdal_truth.h"
#include "render/renderer.h"
#include "render/shared_data.h"

using namespace nepho;

namespace {

/// All of them take a minute and a half; these are one of each kind.
bool left_out(const std::string& file) {
  const char* full = std::getenv("NEPHO_TEST_FULL");
  if (full && std::string(full) == "1") return false;
  const auto is = [&](const char* name) { return file.ends_with(name); };
  return is("N46E008_swiss_alps.tif") || is("N42E001.hgt") || is("world_bluemarble_2048.tif") || is(".mbtiles") ||
         is("bahamas_landsat7_utm18.tif");
}

constexpr uint32_t kWidth = 96, kHeight = 54;

Scene scene_above(double lat_deg, double lon_deg) {
  setenv("NEPHO_CACHE", NEPHO_TEST_CACHE, 1);
  Scene scene;
  scene.clouds = cloud_sky("clear").value();
  scene.time = "2026-06-20T12:00:00Z";
  scene.camera.lat_deg = lat_deg;
  scene.camera.lon_deg = lon_deg;
  scene.camera.pitch_deg = -90.0;
  scene.render.width = kWidth;
  scene.render.height = kHeight;
  return scene;
}

/// A pixel of the picture, from its layers.
struct Seen {
  Geodetic at, beside, below;  ///< the pixel's place, and those of its neighbours
  double albedo[3] = {0.0, 0.0, 0.0};
};

/// What shows land, from a scene as `nepho render` opens it.
std::vector<Seen> draw(GpuFixture& gpu, const Scene& scene) {
  const RasterAccess rasters{
      .opener = make_gdal_opener(), .find_default_earth = find_default_earth, .gdal_version = "GDAL"};
  Renderer renderer(gpu.device, open_terrain(rasters, scene), scene);
  const RenderResult result = renderer.render({.display = false, .layers = true, .wanted = {}});
  const ImageBuffer& image = result.layers;
  const auto& at = [&](const char* name) -> const std::vector<float>& { return image.find(name)->values; };
  std::vector<Seen> seen;
  for (size_t i = 0; i < at("surface.mask").size(); ++i) {
    if (at("surface.mask")[i] != 1.0f) continue;
    Seen s;
    const auto place = [&](size_t k) {
      return geodetic_from_ecef(result.pose.ecef_m +
                                dvec3(at("position.dx_m")[k], at("position.dy_m")[k], at("position.dz_m")[k]));
    };
    s.at = place(i);
    s.beside = place(i % kWidth + 1 < kWidth ? i + 1 : i - 1);
    s.below = place(i / kWidth + 1 < kHeight ? i + kWidth : i - kWidth);
    const char* const names[] = {"albedo.R", "albedo.G", "albedo.B"};
    for (size_t b = 0; b < 3; ++b) s.albedo[b] = static_cast<double>(at(names[b])[i]);
    // The layers in degrees say the same, to the floats that they are.
    REQUIRE(std::abs(static_cast<double>(at("position.lat_deg")[i]) - s.at.lat_deg()) < 2e-5);
    REQUIRE(std::abs(std::remainder(static_cast<double>(at("position.lon_deg")[i]) - s.at.lon_deg(), 360.0)) < 4e-5);
    seen.push_back(s);
  }
  return seen;
}

/// The larger side of what a pixel covers, in pixels of the source.
double footprint_px(const GdalTruth& source, const Seen& s) {
  const auto at = [&](const Geodetic& g) { return source.pixel_at(g.lat_deg(), g.lon_deg()); };
  const auto apart = [&](const Geodetic& g) { return std::hypot(at(g).x - at(s.at).x, at(g).y - at(s.at).y); };
  return std::max(apart(s.beside), apart(s.below));
}
constexpr double kOneToOne_px = 1.05;

double linear(double srgb_255) {
  const double v = srgb_255 / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

}  // namespace

TEST_CASE("gpu: every elevation raster of the shared data is drawn in the right place by its path alone") {
  GpuFixture gpu;
  for (const std::string file : {"dem/mt_fuji_90m.tif", "dem/N46E008_swiss_alps.tif", "dem/N42E001.hgt"}) {
    CAPTURE(file);
    const std::string path = left_out(file) ? "" : shared_data(file);
    if (path.empty()) continue;
    const GdalTruth source(path);
    REQUIRE(source.good());
    // Straight down on a slope, from low enough for pixels of a fifth of a sample.
    const auto [lat, lon] = source.place_of(source.width() * 0.43, source.height() * 0.38);
    Scene scene = scene_above(lat, lon);
    scene.terrain.elevation.push_back({.path = path});
    scene.camera.agl_m = 1000.0;
    size_t compared = 0, outside = 0;
    double range_sum = 0.0, worst = 0.0;
    for (const Seen& s : draw(gpu, scene)) {
      const auto range = source.around(s.at.lat_deg(), s.at.lon_deg(), 1, 1);
      if (!range) continue;
      const double msl_m = s.at.height_m - Geoid::egm96().undulation_m(s.at.lat_rad, s.at.lon_rad);
      const double beyond = std::max(range->low - msl_m, msl_m - range->high);
      worst = std::max(worst, beyond);
      ++compared;
      outside += beyond > 0.0;
      range_sum += range->high - range->low;
    }
    const double range_m = range_sum / static_cast<double>(std::max<size_t>(compared, 1));
    MESSAGE(file << ": " << compared << " points, samples around a point range over " << range_m << " m, " << outside
                 << " points are outside that, by " << worst << " m at most");
    CHECK(compared > kWidth * kHeight / 2);
    CHECK(range_m > 20.0);  // or nothing would show a shift
    CHECK(outside == 0);
  }
}

TEST_CASE("gpu: every picture of the shared data is drawn in the right place and colour by its path alone") {
  struct Picture {
    std::string file;
    const char* truth;  // GDAL reads no folders of tiles: the same tiles as one file
    double lat, lon;    // to look at
    /// Share of places within 3/255 of GDAL's value. Pictures that have to be warped are interpolated twice, at half a
    /// pixel: where neighbours differ by much, that shows.
    double least_near = 0.99;
  };
  GpuFixture gpu;
  for (const Picture& picture :
       {Picture{"imagery/bahamas_landsat7_utm18.tif", nullptr, 24.7, -77.95, 0.6},
        Picture{"imagery/boston-inset-wgs84.tif", nullptr, 42.35, -71.25},
        Picture{"imagery/world_bluemarble_2048.tif", nullptr, 22.0, 10.0, 0.98},
        Picture{"imagery/bluemarble_z0-3_DERIVED.mbtiles", nullptr, 48.0, 16.0, 0.97},
        Picture{"imagery/bluemarble_xyz", "imagery/bluemarble_z0-3_DERIVED.mbtiles", -14.0, -55.0, 0.99},
        Picture{"imagery/plain_1.mbtiles", nullptr, 47.0, 8.0, 0.94},
        Picture{"imagery/watermask_august_8192.jpg", nullptr, 62.0, 27.0}}) {
    CAPTURE(picture.file);
    const std::string path = left_out(picture.file) ? "" : shared_data(picture.file);
    if (path.empty()) continue;
    const GdalTruth source(picture.truth ? shared_data(picture.truth) : path);
    REQUIRE(source.good());
    // One pixel of the picture for one of the source, along its shorter side.
    const GdalTruth::Pixel middle = source.pixel_at(picture.lat, picture.lon);
    const double pixel_m = source.pixel_m(middle.x, middle.y);
    Scene scene = scene_above(picture.lat, picture.lon);
    scene.imagery.files.push_back({.path = path});
    scene.camera.height_m = pixel_m * kHeight / (2.0 * std::tan(rad_from_deg(22.5)));
    size_t compared = 0, outside = 0, even = 0, off = 0, near = 0, one_to_one = 0;
    double contrast = 0.0, worst_even = 0.0;
    for (const Seen& s : draw(gpu, scene)) {
      // The tile's texels and the filter mix what lies within two samples.
      std::optional<GdalTruth::Range> bands[3];
      for (int b = 0; b < 3; ++b) bands[b] = source.around(s.at.lat_deg(), s.at.lon_deg(), b + 1, 2);
      if (!bands[0] || !bands[1] || !bands[2]) continue;
      ++compared;
      constexpr double kClose = 3.0 / 255.0;
      bool within = true, is_even = true, close = true;
      for (size_t b = 0; b < 3; ++b) {
        const double low = linear(bands[b]->low), high = linear(bands[b]->high);
        within &= s.albedo[b] > low - kClose && s.albedo[b] < high + kClose;
        is_even &= high - low < kClose;
        close &= std::abs(s.albedo[b] - linear(bands[b]->at)) < kClose;
        if (high - low < kClose) worst_even = std::max(worst_even, std::abs(s.albedo[b] - linear(bands[b]->at)));
        contrast = std::max(contrast, high - low);
      }
      outside += !within;
      bool is_near = true;
      for (int b = 0; b < 3; ++b)
        is_near &=
            std::abs(s.albedo[b] - linear(source.between(s.at.lat_deg(), s.at.lon_deg(), b + 1).value())) < kClose;
      // Where a pixel covers more than one of the source it shows their mean, and the sampling is not 1:1.
      if (footprint_px(source, s) <= kOneToOne_px) {
        ++one_to_one;
        near += is_near;
      }
      even += is_even;
      off += is_even && !close;
    }
    MESSAGE(picture.file << ": " << compared << " points, " << even
                         << " of them in even colour, where the albedo is off by " << worst_even * 255.0
                         << "/255 at most; " << outside << " outside the colours around; of " << one_to_one
                         << " drawn 1:1 " << 100.0 * static_cast<double>(near) / static_cast<double>(one_to_one)
                         << " % within 3/255 of GDAL's bilinear value");
    CHECK(one_to_one > compared / 20);
    CHECK(compared > kWidth * kHeight / 10);
    CHECK(contrast > 0.05);  // there is something to see
    CHECK(off == 0);
    CHECK(outside == 0);
    // A pixel that covers one of the source has its mean there, which is the bilinear value at the pixel's centre.
    CHECK(static_cast<double>(near) >= picture.least_near * static_cast<double>(one_to_one));
  }
}
