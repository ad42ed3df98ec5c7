// Real data: the default Earth where its Debian packages are installed, and the Fuji DEM where it is at hand.
#include <doctest/doctest.h>

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <glm/gtc/packing.hpp>

#include "gpu/gpu_fixture.h"
#include "rasters/default_earth.h"
#include "rasters/gdal_opener.h"
#include "terrain/ground_texels.h"
#include "terrain/terrain.h"
#include "terrain_fixture.h"

using namespace nepho;
using namespace nepho::test;

namespace {

const char* const kFuji = "/work/shared/data/dem/mt_fuji_90m.tif";

TerrainSources default_earth() {
  const DefaultEarth files = find_default_earth();
  TerrainSources sources;
  const auto opener = make_gdal_opener();
  if (!files.elevation.empty()) {
    sources.elevation.push_back(opener->open_elevation(files.elevation));
    sources.has_default = true;
  }
  if (!files.imagery.empty()) sources.imagery.push_back(opener->open_imagery(files.imagery));
  if (!files.night.empty()) sources.night_lights = opener->open_imagery(files.night);
  sources.geoid = std::make_shared<Geoid>(Geoid::find_egm96());
  return sources;
}

struct Picture {
  std::vector<float> depth_m;
  std::vector<uint16_t> albedo, normal;
};

Picture draw(gpu::GraphExecutor& executor, Terrain& terrain, FrameInfo frame, const char* name) {
  const std::clock_t before = std::clock();
  terrain.prepare(frame);
  const double prepare_cpu_ms = 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
  FrameGraph graph;
  frame.buffer = graph.constants("frame", frame.constants);
  const Terrain::Outputs out = terrain.add(graph, frame);
  for (const ImageRef image : {out.depth_m, out.albedo, out.normal}) graph.keep(image);
  executor.run(graph);
  const std::clock_t between = std::clock();  // the first run compiles shaders
  executor.run(graph);
  const double run_cpu_ms = 1e3 * static_cast<double>(std::clock() - between) / CLOCKS_PER_SEC;
  const Terrain::Stats& s = terrain.stats();
  MESSAGE(std::string(name), ": ", s.tiles_drawn, " tiles, ", s.triangles, " triangles, level ", s.deepest_level,
          "; select ", s.select_ms, " ms, build ", s.build_ms, " ms, upload ", s.upload_ms, " ms; blocks ",
          s.blocks_read, "; processor time: prepare ", prepare_cpu_ms, " ms, draw ", run_cpu_ms, " ms");
  for (const gpu::PassTiming& t : executor.timings()) MESSAGE(t.name, " ", t.gpu_ms, " ms");
  return {executor.read<float>(out.depth_m), executor.read<uint16_t>(out.albedo), executor.read<uint16_t>(out.normal)};
}

/// For a person to look at, when NEPHO_TEST_PICTURES names a folder: albedo lit from the upper left, as PPM.
void save(const Picture& p, const FrameInfo& frame, const std::string& name) {
  const char* folder = std::getenv("NEPHO_TEST_PICTURES");
  if (!folder) return;
  std::FILE* file = std::fopen((std::filesystem::path(folder) / (name + ".ppm")).c_str(), "wb");
  if (!file) return;
  std::fprintf(file, "P6\n%u %u\n255\n", frame.extent.width, frame.extent.height);
  const auto half = [](uint16_t h) { return glm::unpackHalf2x16(h).x; };
  const vec3 light = glm::normalize(frame.constants.up * 2.0f - frame.constants.right - frame.constants.forward);
  for (size_t i = 0; i < p.depth_m.size(); ++i) {
    const vec3 n(half(p.normal[4 * i]), half(p.normal[4 * i + 1]), half(p.normal[4 * i + 2]));
    const float mask = half(p.albedo[4 * i + 3]);
    const float shade = 0.2f + 2.0f * std::max(0.0f, glm::dot(n, light));
    for (size_t b = 0; b < 3; ++b) {
      const float albedo = mask == 2.0f ? (b == 2 ? 0.08f : 0.03f) : half(p.albedo[4 * i + b]);
      const float v = mask == 0.0f ? 0.0f : std::pow(std::min(1.0f, albedo * shade), 1.0f / 2.2f);
      std::fputc(static_cast<int>(v * 255.0f), file);
    }
  }
  std::fclose(file);
}

}  // namespace

TEST_CASE("earth: views of the default data load fast and have no holes") {
  if (find_default_earth().elevation.empty()) {
    MESSAGE("skipped: the default Earth's packages are not installed");
    return;
  }
  GpuFixture gpu;
  const auto start = std::chrono::steady_clock::now();
  Terrain terrain(gpu.device, default_earth(), {});
  MESSAGE("start ", std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count(), " ms");
  struct View {
    const char* name;
    double lat, lon, agl, heading, pitch, fov;
  };
  for (const View& v :
       {View{"orbit", 36.0, 137.0, 400e3, 30.0, -35.0, 60.0},
        View{"geostationary", 0.0, 140.7, 35786e3, 0.0, -90.0, 20.0}, View{"ground", 46.5, 8.0, 2.0, 170.0, 5.0, 60.0},
        View{"aloft", 35.3, 138.5, 10e3, 60.0, -15.0, 60.0}, View{"south_pole", -90.0, 0.0, 2.0, 0.0, -5.0, 60.0},
        View{"coast", 43.3, 5.2, 30e3, 90.0, -30.0, 60.0}}) {
    Geodetic at = Geodetic::from_degrees(v.lat, v.lon);
    at.height_m = v.agl + std::max(0.0, terrain.ground_height_m(at.lat_rad, at.lon_rad));
    const FrameInfo frame = frame_at(at, Attitude::from_degrees(v.heading, v.pitch), v.fov, {640, 360});
    const Picture p = draw(gpu.executor, terrain, frame, v.name);
    save(p, frame, v.name);
    size_t holes = 0;
    for (uint32_t y = 0; y < 360; ++y)
      for (uint32_t x = 0; x < 640; ++x)
        // The drawn surface is nowhere 150 m below the ellipsoid; the silhouette may be half a pixel off.
        if (p.depth_m[y * 640 + x] == 1.0e10f) {
          bool inside = true;
          for (const double corner_y : {0.0, 1.0})
            for (const double corner_x : {0.0, 1.0})
              inside &= hit_ellipsoid(frame.camera_ecef_m, pixel_ray(frame, x + corner_x, y + corner_y), -150.0) > 0.0;
          holes += inside;
        }
    CHECK(holes == 0);
    CHECK(terrain.stats().tiles_drawn < 300);
  }
}

TEST_CASE("earth: the ground map tells land from sea from Tokyo to the other side of the Pacific") {
  if (find_default_earth().elevation.empty() || find_default_earth().imagery.empty()) {
    MESSAGE("skipped: the default Earth's packages are not installed");
    return;
  }
  GpuFixture gpu;
  const Terrain terrain(gpu.device, default_earth(), {});
  const shared::RegionMap map = make_region_map(ecef_from_geodetic(Geodetic::from_degrees(35.68, 139.77)), 10e3, 11);
  GroundTexels texels;
  for (const char* name : {"first", "again"}) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t before = std::clock();
    texels = sample_ground(terrain.heights(), terrain.imagery(), map);
    MESSAGE("ground map, ", std::string(name), ": ",
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count(),
            " ms; processor time ", 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC, " ms");
  }
  struct Known {
    const char* name;
    double lat, lon;
    bool land;
  };
  for (const Known& k : {Known{"Kanto plain", 36.1, 139.6, true}, Known{"Sagami bay", 35.0, 139.4, false},
                         Known{"Pacific", 20.0, 170.0, false}, Known{"Siberia", 62.0, 125.0, true},
                         Known{"Australia", -25.0, 134.0, true}, Known{"Canada", 60.0, -115.0, true},
                         Known{"Nevada", 39.0, -117.0, true}, Known{"south of Hawaii", 10.0, -160.0, false}}) {
    CAPTURE(std::string(k.name));
    const glm::vec2 xy =
        shared::region_xy(map, vec3(map_direction_from_ecef(ecef_from_geodetic(Geodetic::from_degrees(k.lat, k.lon)))));
    const uint32_t level = shared::region_level(map, xy);
    REQUIRE(level < map.levels);
    const glm::vec2 at = (xy / shared::region_half_m(map, level) * 0.5f + 0.5f) * float{GroundTexels::kSide};
    const size_t texel =
        (level * GroundTexels::kSide + static_cast<size_t>(at.y)) * GroundTexels::kSide + static_cast<size_t>(at.x);
    const glm::vec4& albedo = texels.albedo[texel];
    CHECK(albedo.a == (k.land ? 1.0f : 0.0f));
    // Land at these places is neither soot nor snow in the picture of summer.
    if (k.land) {
      CHECK(albedo.g > 0.02f);
      CHECK(albedo.g < 0.4f);
      CHECK(texels.height_m[texel] > 0.0f);
    }
  }
  // One level as wide as the whole Earth, of equal areas: 29 % of it is land.
  const shared::RegionMap whole =
      make_region_map(ecef_from_geodetic(Geodetic::from_degrees(35.68, 139.77)), 2.0 * 6378137.0, 1);
  texels = sample_ground(terrain.heights(), terrain.imagery(), whole);
  double land = 0.0, count = 0.0;
  for (uint32_t j = 0; j < GroundTexels::kSide; ++j)
    for (uint32_t i = 0; i < GroundTexels::kSide; ++i) {
      if (std::hypot(i + 0.5 - GroundTexels::kSide / 2.0, j + 0.5 - GroundTexels::kSide / 2.0) >
          GroundTexels::kSide / 2.0)
        continue;
      land += static_cast<double>(texels.albedo[size_t{j} * GroundTexels::kSide + i].a);
      count += 1.0;
    }
  CHECK(land / count == doctest::Approx(0.292).epsilon(0.03));
}

TEST_CASE("earth: the ray through the picture's centre meets Mt Fuji within 60 m of the DEM") {
  if (!std::filesystem::exists(kFuji)) {
    MESSAGE("skipped: no Fuji DEM");
    return;
  }
  GpuFixture gpu;
  TerrainSources sources = default_earth();
  sources.elevation.push_back(make_gdal_opener()->open_elevation(kFuji));
  Terrain terrain(gpu.device, std::move(sources), {});
  const Geodetic at = Geodetic::from_degrees(35.47, 138.60, 2500.0);
  const auto attitude = heading_pitch_towards(at, Geodetic::from_degrees(35.3606, 138.7274, 3700.0));
  const FrameInfo frame = frame_at(at, *attitude, 45.0, {641, 361});
  const Picture p = draw(gpu.executor, terrain, frame, "fuji");
  save(p, frame, "fuji");
  double worst = 0.0;
  size_t compared = 0;
  for (const int32_t dy : {-20, 0, 40, 80})
    for (const int32_t dx : {-40, 0, 40}) {
      const auto x = static_cast<uint32_t>(320 + dx), y = static_cast<uint32_t>(180 + dy);
      const dvec3 ray = pixel_ray(frame, x + 0.5, y + 0.5);
      double t = 1000.0;
      const auto above = [&](double at_t) {
        const Geodetic g = geodetic_from_ecef(frame.camera_ecef_m + ray * at_t);
        return g.height_m - terrain.ground_height_m(g.lat_rad, g.lon_rad);
      };
      while (t < 40e3 && above(t) > 0.0) t += 5.0;
      const float depth = p.depth_m[y * 641 + x];
      if (t >= 40e3 || depth > 40e3f) continue;
      ++compared;
      const double off = std::abs(static_cast<double>(depth) - t);
      worst = std::max(worst, off);
      if (dx == 0 && dy == 0) {
        MESSAGE("centre: ", t, " m, off by ", off, " m");
        CHECK(off < 60.0);
      }
    }
  CHECK(terrain.stats().tiles_drawn < 150);
  MESSAGE("worst of ", compared, ": ", worst, " m");
  CHECK(compared >= 6);
}
