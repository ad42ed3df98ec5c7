// From 40,000 km to 2 m above the rim of Fuji's crater in steps of 1 %: no step shows more change than those around it.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <glm/geometric.hpp>

#include "rasters/default_earth.h"
#include "rasters/gdal_opener.h"
#include "render/reference_scene.h"
#include "render/shared_data.h"

namespace nepho {
namespace {
using namespace test;

constexpr double kRimLat_deg = 35.3645, kRimLon_deg = 138.7315;  // the crater's rim is 500 m wide; its north-east
constexpr double kFarthest_m = 40e6;
constexpr double kStep = 0.99;
constexpr Extent2D kExtent{128, 72};

TerrainSources fuji(bool& complete) {
  const auto opener = make_gdal_opener();
  const DefaultEarth files = find_default_earth();
  TerrainSources sources;
  const std::string dem = shared_data("dem/mt_fuji_90m.tif");
  complete = !files.elevation.empty() && !files.imagery.empty() && !dem.empty();
  if (!complete) return sources;
  sources.elevation = {opener->open_elevation(files.elevation), opener->open_elevation(dem)};
  sources.has_default = true;
  sources.imagery = {opener->open_imagery(files.imagery)};
  sources.geoid = std::make_shared<Geoid>(Geoid::find_egm96());
  return sources;
}

Scene clear_noon() {
  Scene scene = reference_scene(CloudParams{}, kExtent);
  scene.clouds.layers.clear();
  scene.time = "2026-04-10T00:30:00Z";  // half past nine at Fuji: slopes are lit from the side
  scene.camera.lat_deg = kRimLat_deg;
  scene.camera.lon_deg = kRimLon_deg;
  scene.camera.agl_m = kFarthest_m;
  scene.camera.height_m.reset();
  scene.camera.look_at.reset();
  scene.camera.heading_deg = 0.0;
  scene.camera.pitch_deg = -90.0;
  scene.camera.fov_deg = 45.0;
  scene.render.quality = "medium";
  scene.render.frames = 1;
  // `auto` takes another method above 30 km: a step of 0.4 of 255 levels (docs/light.md).
  scene.shafts.method = "shadow-length";
  return scene;
}

struct Picture {
  std::vector<double> shade;  ///< what an eye would see: luminance over white to the power of 1/2.2
  std::vector<float> depth_m;
  CameraPose pose;
};

double height_of(int step) { return kFarthest_m * std::pow(kStep, step); }

Picture picture_at(Renderer& renderer, Scene& scene, int step) {
  scene.camera.agl_m = std::max(height_of(step), 2.0);
  renderer.set_camera(scene.camera);
  RenderRequest request;
  request.display = false;
  request.wanted = {"R", "G", "B", "depth.Z"};
  const RenderResult result = renderer.render(request);
  const std::vector<float>&r = channel(result.layers, "R"), &g = channel(result.layers, "G"),
        &b = channel(result.layers, "B");
  Picture out;
  out.pose = result.pose;
  out.depth_m = channel(result.layers, "depth.Z");
  constexpr double kWhite_cd_m2 = 15000.0;
  for (size_t i = 0; i < r.size(); ++i) {
    const double y =
        0.2126 * static_cast<double>(r[i]) + 0.7152 * static_cast<double>(g[i]) + 0.0722 * static_cast<double>(b[i]);
    out.shade.push_back(std::pow(std::clamp(y / kWhite_cd_m2, 0.0, 1.0), 1.0 / 2.2));
  }
  return out;
}

/// Place in `p` where a point is seen, pixels; centres at .5.
glm::dvec2 project(const CameraPose& pose, const dvec3& point) {
  const dvec3 v = point - pose.ecef_m;
  const double w = glm::dot(v, pose.axes.forward), tan_y = std::tan(pose.fov_rad / 2);
  const double x = glm::dot(v, pose.axes.right) / w / (tan_y * kExtent.width / kExtent.height),
               y = glm::dot(v, pose.axes.up) / w / tan_y;
  return {(x + 1.0) / 2.0 * kExtent.width, (1.0 - y) / 2.0 * kExtent.height};
}

dvec3 point_at(const Picture& p, uint32_t x, uint32_t y) {
  const double tan_y = std::tan(p.pose.fov_rad / 2), tan_x = tan_y * kExtent.width / kExtent.height;
  const dvec3 dir =
      glm::normalize(p.pose.axes.forward + ((x + 0.5) * 2.0 / kExtent.width - 1.0) * tan_x * p.pose.axes.right +
                     (1.0 - (y + 0.5) * 2.0 / kExtent.height) * tan_y * p.pose.axes.up);
  return p.pose.ecef_m + dir * static_cast<double>(p.depth_m[y * kExtent.width + x]);
}

/// Mean difference of the later picture from the earlier one warped by the camera's motion, on ground in both.
double change(const Picture& from, const Picture& to) {
  double sum = 0.0;
  size_t count = 0;
  for (uint32_t y = 0; y < kExtent.height; ++y)
    for (uint32_t x = 0; x < kExtent.width; ++x) {
      if (to.depth_m[y * kExtent.width + x] > 1e9f) continue;
      const glm::dvec2 at = project(from.pose, point_at(to, x, y)) - 0.5;
      const auto i = static_cast<int>(std::floor(at.x)), j = static_cast<int>(std::floor(at.y));
      if (i < 0 || j < 0 || i + 1 >= static_cast<int>(kExtent.width) || j + 1 >= static_cast<int>(kExtent.height))
        continue;
      const double fx = at.x - i, fy = at.y - j;
      double was = 0.0;
      bool ground = true;
      for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
          const size_t k = static_cast<size_t>(j + dy) * kExtent.width + static_cast<size_t>(i + dx);
          ground &= from.depth_m[k] < 1e9f;
          was += (dx ? fx : 1.0 - fx) * (dy ? fy : 1.0 - fy) * from.shade[k];
        }
      if (!ground) continue;
      sum += std::abs(to.shade[y * kExtent.width + x] - was);
      ++count;
    }
  return count ? sum / static_cast<double>(count) : 0.0;
}

/// Changes of the steps first..last; steps that stand out are told.
void check_continuous(int first, int last) {
  bool complete = false;
  TerrainSources sources = fuji(complete);
  if (!complete) {
    MESSAGE("the default Earth or the DEM of Fuji is not here: the zoom is not tested");
    return;
  }
  GpuFixture gpu;
  Scene scene = clear_noon();
  Renderer renderer(gpu.device, std::move(sources), scene);
  std::vector<double> changes;
  Picture before = picture_at(renderer, scene, first);
  for (int step = first + 1; step <= last; ++step) {
    Picture now = picture_at(renderer, scene, step);
    changes.push_back(change(before, now));
    before = std::move(now);
  }
  if (const char* file = std::getenv("NEPHO_ZOOM_CSV")) {
    std::ofstream csv(file);
    csv << "step,height_m,change\n";
    for (size_t i = 0; i < changes.size(); ++i)
      csv << first + 1 + static_cast<int>(i) << ',' << height_of(first + 1 + static_cast<int>(i)) << ',' << changes[i]
          << '\n';
  }
  constexpr size_t kAround = 20;
  /// A display shows no less: a hundredth of one of 255 levels.
  constexpr double kInvisible = 0.01 / 255.0;
  double worst = 0.0, largest = 0.0;
  for (size_t i = 0; i < changes.size(); ++i) {
    const size_t begin = std::min(i > kAround ? i - kAround : 0, changes.size() > 41 ? changes.size() - 41 : 0);
    std::vector<double> window(changes.begin() + static_cast<std::ptrdiff_t>(begin),
                               changes.begin() + static_cast<std::ptrdiff_t>(std::min(begin + 41, changes.size())));
    std::nth_element(window.begin(), window.begin() + static_cast<std::ptrdiff_t>(window.size() / 2), window.end());
    const double median = window[window.size() / 2];
    CAPTURE(first + 1 + static_cast<int>(i));
    CAPTURE(height_of(first + 1 + static_cast<int>(i)));
    CHECK(changes[i] <= std::max(2.0 * median, kInvisible));
    worst = std::max(worst, changes[i] / std::max(median, kInvisible / 2.0));
    largest = std::max(largest, changes[i]);
  }
  MESSAGE("steps " << first << " to " << last << ": largest change " << largest << " of the display's range, at most "
                   << worst << " times the median around it");
}

}  // namespace

TEST_CASE("gpu: the ground comes nearer without a step: tiles change from 260 to 140 km") {
  check_continuous(500, 560);
}
TEST_CASE("gpu: the ground comes nearer without a step: tiles change from 21 to 11 km") { check_continuous(750, 810); }
TEST_CASE("gpu: the ground comes nearer without a step: tiles change from 270 to 150 m") {
  check_continuous(1185, 1245);
}

TEST_CASE("gpu: full: from 40,000 km to 2 m above the crater's rim in 1,700 steps") {
  if (!std::getenv("NEPHO_TEST_FULL")) return;
  check_continuous(0, 1700);
}

}  // namespace nepho
