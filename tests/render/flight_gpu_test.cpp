// Flights over the default Earth and a large projected raster, drawn while tiles are made in the background: memory
// keeps to its budgets, what is missing is covered, and no frame takes much longer than the others.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>

#include "geo/frames.h"
#include "rasters/default_earth.h"
#include "rasters/gdal_opener.h"
#include "rasters/raster_test_tools.h"
#include "render/reference_scene.h"

namespace nepho {
namespace {
using namespace test;

constexpr double kStep_s = 0.1;

/// Heights every 10 m in UTM zone 54 north of Fuji: hills in hills, 0 to 2000 m.
std::string utm_raster(const std::filesystem::path& folder, int side) {
  RasterRecipe r;
  r.width = r.height = side;
  r.type = GDT_Int16;
  r.geotransform = {350000.0, 10.0, 0.0, 3960000.0, 0.0, -10.0};
  r.crs = "EPSG:32654";
  r.options = {"TILED=YES", "COMPRESS=DEFLATE", "ZLEVEL=1"};
  std::vector<double> wave(static_cast<size_t>(side));
  for (int i = 0; i < side; ++i)
    wave[static_cast<size_t>(i)] = std::sin(i / 700.0) + 0.5 * std::sin(i / 130.0) + 0.1 * std::sin(i / 21.0);
  r.value = [wave](int, int x, int y) {
    return 1000.0 + 390.0 * (wave[static_cast<size_t>(x)] + wave[static_cast<size_t>(y)]) - 39.0;
  };
  r.finish = [](GDALDataset& dataset) { dataset.GetRasterBand(1)->SetNoDataValue(-32768); };
  const std::string path = make_raster(folder / "hills.tif", r);
  GDALDatasetUniquePtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
  const int overviews[] = {2, 4, 8, 16, 32};
  REQUIRE(dataset->BuildOverviews("AVERAGE", 5, overviews, 0, nullptr, nullptr, nullptr) == CE_None);
  return path;
}

TerrainSources sources_with(const std::string& file) {
  const auto opener = make_gdal_opener();
  const DefaultEarth files = find_default_earth();
  TerrainSources sources;
  sources.has_default = !files.elevation.empty();
  if (sources.has_default) sources.elevation.push_back(opener->open_elevation(files.elevation));
  sources.elevation.push_back(opener->open_elevation(file));
  if (!files.imagery.empty()) sources.imagery.push_back(opener->open_imagery(files.imagery));
  sources.geoid = std::make_shared<Geoid>(Geoid::find_egm96());
  return sources;
}

uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  uint64_t size = 0, resident = 0;
  statm >> size >> resident;
  return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

struct Flight {
  const char* name;
  double speed_mps, height_m, pitch_deg;
};

void fly(const Flight& flight, Extent2D extent, double seconds, int raster_side) {
  const TempFolder folder;
  GpuFixture gpu;
  Scene scene = reference_scene(CloudParams{}, extent);
  scene.clouds.layers.clear();
  scene.time = "2026-04-10T00:30:00Z";
  scene.render.quality = "medium";
  scene.render.frames = 1;
  scene.render.exposure_ev100 = 14.0;
  scene.terrain.host_budget_mb = 192;
  scene.terrain.gpu_budget_mb = 192;
  scene.terrain.disk_cache_mb = 0;
  scene.camera.look_at.reset();
  scene.camera.agl_m.reset();
  scene.camera.heading_deg = 60.0;
  scene.camera.pitch_deg = flight.pitch_deg;
  const double heading_rad = rad_from_deg(60.0);
  const auto place = [&](CameraParams& camera, double time_s) {
    // A straight line over the map is good enough for a minute's flight.
    const double way_m = flight.speed_mps * time_s;
    camera.lat_deg = 35.25 + deg_from_rad(way_m * std::cos(heading_rad) / 6371e3);
    camera.lon_deg = 139.5 + deg_from_rad(way_m * std::sin(heading_rad) / 6371e3 / std::cos(rad_from_deg(35.5)));
    camera.height_m = flight.height_m;
  };
  place(scene.camera, 0.0);
  Renderer renderer(gpu.device, sources_with(utm_raster(folder.path(), raster_side)), scene);
  RenderRequest request;
  request.layers = true;
  request.display = true;
  request.wanted = {"depth.Z"};
  request.incomplete_ok = true;
  request.ground_wait_s = 10.0;  // takes off over ground that is there
  (void)renderer.render(request);
  request.ground_wait_s = 0.0;
  request.frame_interval_s = kStep_s;
  const uint64_t resident_before = resident_bytes();
  uint64_t resident_most = resident_before;
  std::vector<double> frame_ms;
  size_t missing = 0, most_missing = 0;
  const auto frames = static_cast<int>(seconds / kStep_s);
  for (int i = 1; i <= frames; ++i) {
    CameraParams ahead = scene.camera;
    place(ahead, kStep_s * i + 1.0);
    place(scene.camera, kStep_s * i);
    const auto start = std::chrono::steady_clock::now();
    renderer.set_camera(scene.camera);
    const RenderResult result = renderer.render(request);
    renderer.prefetch(ahead);
    frame_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    const Terrain::Stats& stats = renderer.terrain().stats();
    missing += stats.tiles_missing;
    most_missing = std::max<size_t>(most_missing, stats.tiles_missing);
    resident_most = std::max(resident_most, resident_bytes());
    REQUIRE(stats.gpu_bytes <= uint64_t{scene.terrain.gpu_budget_mb} << 20);
    REQUIRE(renderer.terrain().caches().memory->peak_bytes() <= uint64_t{scene.terrain.host_budget_mb} << 20);
    // Whatever is missing, ground is drawn where there is ground: straight down the picture's lower edge.
    const std::vector<float>& depth = channel(result.layers, "depth.Z");
    REQUIRE(depth[(extent.height - 1) * extent.width + extent.width / 2] < 1e7f);
  }
  std::vector<double> sorted = frame_ms;
  std::sort(sorted.begin(), sorted.end());
  const double median = sorted[sorted.size() / 2], late = sorted[sorted.size() * 99 / 100];
  // What the process grew by: tiles, blocks and what the system's allocator keeps.
  CHECK(resident_most - resident_before <=
        (uint64_t{scene.terrain.host_budget_mb + scene.terrain.gpu_budget_mb} << 20));
  CHECK(most_missing < 400);
  MESSAGE(std::string(flight.name) << ", " << frames << " frames: median " << median << " ms, 99 % within " << late << " ms ("
                      << late / median << " times), longest " << sorted.back() << " ms; tiles missing "
                      << static_cast<double>(missing) / frames << " on average; memory grew by "
                      << ((resident_most - resident_before) >> 20) << " MiB, host cache at most "
                      << (renderer.terrain().caches().memory->peak_bytes() >> 20) << " MiB, GPU "
                      << (renderer.terrain().stats().gpu_bytes >> 20) << " MiB, made "
                      << renderer.terrain().stats().background.loaded << " tiles, cancelled "
                      << renderer.terrain().stats().background.cancelled);
}

constexpr Flight kLow{"250 m/s at 3 km", 250.0, 3000.0, -15.0}, kOrbit{"7.6 km/s at 400 km", 7600.0, 400e3, -50.0};

}  // namespace

TEST_CASE("gpu: a flight at 250 m/s keeps to its budgets") { fly(kLow, {160, 90}, 3.0, 1500); }
TEST_CASE("gpu: a flight at 7.6 km/s keeps to its budgets") { fly(kOrbit, {160, 90}, 3.0, 1500); }

TEST_CASE("gpu: full: a minute's flight at 250 m/s over 10,000 x 10,000 heights") {
  if (full_size()) fly(kLow, {320, 180}, 60.0, 10000);
}
TEST_CASE("gpu: full: a minute's flight at 7.6 km/s over 10,000 x 10,000 heights") {
  if (full_size()) fly(kOrbit, {320, 180}, 60.0, 10000);
}

}  // namespace nepho
