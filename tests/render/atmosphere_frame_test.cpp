// The air in whole frames: new air while frames go on, moonlight, the darkest nights, tiles, an eclipse. Three
// wavelengths and two orders: nothing here depends on more.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>

#include "astro/sky_bodies.h"
#include "atmosphere/atmosphere_probe.h"
#include "atmosphere/luminance.h"
#include "base/error.h"
#include "geo/planet_view.h"
#include "gpu/gpu_fixture.h"
#include "rasters/default_earth.h"
#include "rasters/gdal_opener.h"
#include "render/frame_setup.h"
#include "render/renderer.h"

using namespace nepho;

namespace {

Scene small_scene(uint32_t width, uint32_t height) {
  ::setenv("NEPHO_CACHE", NEPHO_TEST_CACHE, 1);
  Scene scene;
  scene.atmosphere.spectral = "fast";
  scene.atmosphere.scattering_orders = 2;
  scene.clouds.coverage = 0.0;
  scene.render.width = width;
  scene.render.height = height;
  scene.camera.height_m = 50.0;
  return scene;
}

TerrainSources bare_ground() { return {.elevation = {}, .imagery = {}, .night_lights = nullptr, .geoid = nullptr}; }

const std::vector<float>& channel(const ImageBuffer& image, const std::string& name) {
  const ImageChannel* c = image.find(name);
  REQUIRE(c != nullptr);
  return c->values;
}

struct Picture {
  ImageBuffer layers;
  CameraPose pose;
  dvec3 at(size_t x, size_t y) const {
    const size_t i = y * layers.width + x;
    return {channel(layers, "R")[i], channel(layers, "G")[i], channel(layers, "B")[i]};
  }
  bool is_sky(size_t x, size_t y) const { return channel(layers, "depth.Z")[y * layers.width + x] > 1e9f; }
  /// Unit, ECEF, through a pixel's centre.
  dvec3 direction(size_t px, size_t py) const {
    const double tan_y = std::tan(0.5 * pose.fov_rad), tan_x = tan_y * layers.width / layers.height;
    const double x = 2.0 * (static_cast<double>(px) + 0.5) / layers.width - 1.0;
    const double y = 1.0 - 2.0 * (static_cast<double>(py) + 0.5) / layers.height;
    return glm::normalize(pose.axes.forward + x * tan_x * pose.axes.right + y * tan_y * pose.axes.up);
  }
  /// Sky and ground within the same tile of pixels.
  bool in_mixed_tile(size_t px, size_t py) const {
    bool sky = false, ground = false;
    for (size_t y = py / 16 * 16; y < std::min<size_t>(py / 16 * 16 + 16, layers.height); ++y)
      for (size_t x = px / 16 * 16; x < std::min<size_t>(px / 16 * 16 + 16, layers.width); ++x)
        (is_sky(x, y) ? sky : ground) = true;
    return sky && ground;
  }
  size_t negative() const {
    size_t count = 0;
    for (const char* name : {"R", "G", "B"})
      for (const float v : channel(layers, name)) count += static_cast<size_t>(!(v >= 0.0f) || !std::isfinite(v));
    return count;
  }
  size_t not_positive() const {
    size_t count = 0;
    for (const char* name : {"R", "G", "B"})
      for (const float v : channel(layers, name)) count += static_cast<size_t>(!(v > 0.0f) || !std::isfinite(v));
    return count;
  }
};

Picture draw(Renderer& renderer) {
  RenderResult result = renderer.render({.display = false, .layers = true, .wanted = {"depth.Z"}});
  return {std::move(result.layers), result.pose};
}
Picture draw(gpu::Device& device, const Scene& scene, TerrainSources sources = bare_ground()) {
  Renderer renderer(device, std::move(sources), scene);
  return draw(renderer);
}

double luminance(const dvec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

/// Where a direction, ECEF, is the geodetic vertical.
void stand_under(Scene& scene, const dvec3& up) {
  scene.camera.lat_deg = deg_from_rad(std::asin(up.z));
  scene.camera.lon_deg = deg_from_rad(std::atan2(up.y, up.x));
}

void aim(Scene& scene, const Horizontal& h) {
  scene.camera.heading_deg = deg_from_rad(h.azimuth_rad);
  scene.camera.pitch_deg = deg_from_rad(h.elevation_rad);
}

}  // namespace

TEST_CASE("gpu: new air is computed while pictures show the old, then they are those of a renderer made for it") {
  GpuFixture gpu;
  const std::filesystem::path cache =
      std::filesystem::temp_directory_path() / ("nepho_new_air_" + std::to_string(::getpid()));
  Scene scene = small_scene(33, 17);
  ::setenv("NEPHO_CACHE", cache.c_str(), 1);
  Renderer renderer(gpu.device, bare_ground(), scene);
  const auto red = [](const Picture& p) { return channel(p.layers, "R"); };
  const std::vector<float> old = red(draw(renderer));
  CHECK(renderer.atmosphere_progress() == 1.0);

  AtmosphereParams air = scene.atmosphere;
  air.rayleigh.scale_height_m = -8000.0;
  CHECK_THROWS_AS(renderer.set_atmosphere(air), Error);
  air = scene.atmosphere;
  air.spectral = "full";
  CHECK_THROWS_AS(renderer.set_atmosphere(air), Error);
  CHECK(renderer.atmosphere_progress() == 1.0);
  CHECK(red(draw(renderer)) == old);

  air = scene.atmosphere;
  air.mie.optical_depth = 0.3;
  renderer.set_atmosphere(air);
  CHECK(renderer.atmosphere_progress() == 0.0);
  int frames = 0;
  std::vector<float> last;
  double before = 0.0;
  while (renderer.atmosphere_progress() < 1.0 && frames < 1000) {
    // In between bad air is refused again, and the good goes on.
    if (frames == 1) {
      AtmosphereParams bad = air;
      bad.mie.scattering_per_m[1] = NAN;
      CHECK_THROWS_AS(renderer.set_atmosphere(bad), Error);
    }
    last = red(draw(renderer));
    const double progress = renderer.atmosphere_progress();
    CHECK(progress > before);
    before = progress;
    if (progress < 1.0) CHECK(last == old);
    ++frames;
  }
  CHECK(frames > 2);
  CHECK(last != old);
  scene.atmosphere = air;
  CHECK(red(draw(gpu.device, scene)) == last);
  std::filesystem::remove_all(cache);
}

TEST_CASE("gpu: the full moon lights the sky as the sun would, 2.5e-6 times, within a factor of two") {
  GpuFixture gpu;
  Scene scene = small_scene(16, 16);
  scene.time = "2026-01-03T10:03:00Z";  // full moon
  const SkyBodies sky = sky_bodies_at(parse_utc(scene.time));
  const dvec3 moon = sky.moon.dir_ecef;
  // The moon stands at 45 degrees.
  stand_under(scene, glm::normalize(moon + glm::normalize(glm::cross(moon, dvec3(0, 0, 1)))));
  scene.camera.heading_deg = 0.0;
  scene.camera.pitch_deg = 30.0;
  scene.camera.fov_deg = 30.0;
  scene.night_sky.stars = false;  // moonlight alone
  scene.night_sky.airglow_cd_m2 = 0.0;
  const Picture night = draw(gpu.device, scene);
  REQUIRE(glm::dot(sky.sun.dir_ecef, moon) < -0.99);

  AtmosphereProbe probe(gpu.device, std::make_shared<const AtmosphereTables>(gpu.device, scene.atmosphere));
  std::vector<AtmosphereProbe::Case> cases;
  for (size_t y = 0; y < 16; ++y)
    for (size_t x = 0; x < 16; ++x) {
      AtmosphereProbe::Case c{};
      c.planet = make_planet_view(night.pose.ecef_m);
      c.dir = vec3(night.direction(x, y));
      c.sun_dir = vec3(moon);
      c.camera_up = vec3(geodetic_up_ecef(night.pose.at.lat_rad, night.pose.at.lon_rad));
      cases.push_back(c);
    }
  const auto by_sun = probe.ask(shared::kProbeLuminance, cases);
  double least = 1e9, most = 0.0;
  for (size_t i = 0; i < cases.size(); ++i) {
    REQUIRE(night.is_sky(i % 16, i / 16));
    const double ratio = luminance(night.at(i % 16, i / 16)) / luminance(dvec3(by_sun[i].a));
    least = std::min(least, ratio);
    most = std::max(most, ratio);
  }
  MESSAGE("moonlit sky per sunlit sky: " << least << " to " << most);
  CHECK(least > 1.25e-6);
  CHECK(most < 5e-6);
}

TEST_CASE("gpu: in a moonless night nothing is black or negative: land, sea, sky, the night side from orbit and far") {
  const DefaultEarth earth = find_default_earth();
  GpuFixture gpu;
  TerrainSources sources = bare_ground();
  if (earth.elevation.empty() || earth.imagery.empty()) {
    MESSAGE("bare ground alone: marble-data is not installed");
  } else {
    const std::unique_ptr<RasterOpener> opener = make_gdal_opener();
    sources.elevation.push_back(opener->open_elevation(earth.elevation));
    sources.has_default = true;
    sources.imagery.push_back(opener->open_imagery(earth.imagery));
  }
  struct View {
    const char* what;
    double lat, lon, height_m, pitch_deg;
    std::string time;
  };
  // New moon 2026-01-18 19:52 UTC; the sun stands below the horizon by 30 degrees and more in all of these.
  for (const View& v : {View{"land and sky", 35.0, 100.0, 5000.0, 0.0, "2026-01-18T18:00:00Z"},
                        View{"sea and sky", 20.0, 150.0, 20.0, 0.0, "2026-01-18T15:00:00Z"},
                        View{"from orbit, the limb", 25.0, 110.0, 400e3, -20.0, "2026-01-18T17:00:00Z"},
                        View{"the whole night side", 20.0, 115.0, 30e6, -90.0, "2026-01-18T16:20:00Z"}}) {
    for (const bool stars : {true, false}) {
      if (!stars && v.height_m > 100e3) continue;  // space without stars is black
      Scene scene = small_scene(48, 32);
      scene.camera.lat_deg = v.lat;
      scene.camera.lon_deg = v.lon;
      scene.camera.height_m = v.height_m;
      scene.camera.pitch_deg = v.pitch_deg;
      scene.time = v.time;
      scene.atmosphere.spectral = "full";  // whose colours may lie beyond Rec. 709
      scene.night_sky.stars = stars;
      const Picture p = draw(gpu.device, scene, sources);
      CAPTURE(std::string(v.what));
      CAPTURE(stars);
      size_t sky = 0;
      double brightest = 0.0, darkest = 1e9;
      for (size_t y = 0; y < 32; ++y)
        for (size_t x = 0; x < 48; ++x) {
          sky += static_cast<size_t>(p.is_sky(x, y));
          brightest = std::max(brightest, luminance(p.at(x, y)));
          darkest = std::min(darkest, luminance(p.at(x, y)));
        }
      CHECK(sky > 100);
      CHECK(sky < 48 * 32 - 100);
      CHECK(p.negative() == 0);
      CHECK(darkest > 1e-8);
      CHECK(brightest < (v.height_m > 1e6 ? 10.0 : 0.1));  // from afar the limb's air is sunlit, 10 degrees beyond
    }
  }
}

TEST_CASE("gpu: sky pixels are the same in tiles of sky and in tiles that hold ground too, to 0.1 %") {
  GpuFixture gpu;
  struct View {
    const char* time;
    double height_m, pitch_deg;
  };
  for (const View& v : {View{"2026-06-21T00:30:00Z", 50.0, 0.0}, View{"2026-06-21T00:30:00Z", 12e3, -3.0},
                        View{"2026-01-03T13:00:00Z", 50.0, 0.0}}) {
    // The same directions twice: the larger picture has 8 pixels more on every side, so its tiles lie elsewhere.
    Scene scene = small_scene(64, 48);
    scene.time = v.time;
    scene.camera.height_m = v.height_m;
    scene.camera.pitch_deg = v.pitch_deg;
    scene.camera.roll_deg = 5.0;  // the horizon crosses rows of tiles
    scene.camera.fov_deg = 40.0;
    scene.night_sky.stars = false;  // whose pixels are not the same
    const Picture small = draw(gpu.device, scene);
    scene.render.width = 80;
    scene.render.height = 64;
    scene.camera.fov_deg = deg_from_rad(2.0 * std::atan(std::tan(rad_from_deg(20.0)) * 64.0 / 48.0));
    const Picture large = draw(gpu.device, scene);
    size_t compared = 0;
    double worst = 0.0;
    for (size_t y = 0; y < 48; ++y)
      for (size_t x = 0; x < 64; ++x) {
        if (!small.is_sky(x, y) || !large.is_sky(x + 8, y + 8)) continue;
        if (small.in_mixed_tile(x, y) == large.in_mixed_tile(x + 8, y + 8)) continue;
        ++compared;
        const dvec3 a = small.at(x, y), b = large.at(x + 8, y + 8);
        for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(a[c] / b[c] - 1.0));
      }
    CAPTURE(std::string(v.time));
    CAPTURE(v.height_m);
    CHECK(compared > 100);
    CHECK(worst < 1e-3);
  }
}

TEST_CASE("gpu: pictures of any size are covered to their last pixel") {
  GpuFixture gpu;
  for (const glm::uvec2 size : {glm::uvec2(33, 17), glm::uvec2(15, 31), glm::uvec2(1, 1)}) {
    const Picture p = draw(gpu.device, small_scene(size.x, size.y));
    CAPTURE(size.x);
    CHECK(p.not_positive() == 0);
    // Smooth to the edges: the last row and column are like those before.
    if (size.x < 2) continue;
    double worst = 0.0;
    for (size_t x = 0; x < size.x; ++x) worst = std::max(worst, std::abs(p.at(x, 0).y / p.at(x, 1).y - 1.0));
    for (size_t y = 0; y < size.y; ++y)
      if (p.is_sky(size.x - 1, y) == p.is_sky(size.x - 2, y))
        worst = std::max(worst, std::abs(p.at(size.x - 1, y).y / p.at(size.x - 2, y).y - 1.0));
    CHECK(worst < 0.1);
  }
}

TEST_CASE("gpu: in the total eclipse of 2026-08-12 the sun is gone in Cantabria and on the axis of the shadow") {
  GpuFixture gpu;
  const auto at_sea_level = [](const dvec3& ecef) {
    Geodetic g = geodetic_from_ecef(ecef);
    g.height_m = 10.0;
    return g;
  };
  struct Total {
    std::string time;
    Geodetic at;
  };
  std::vector<Total> totals;
  {
    const std::string time = "2026-08-12T17:45:00Z";
    const SkyBodies sky = sky_bodies_at(parse_utc(time));
    // The line through sun and moon meets the ellipsoid.
    const double s = Ellipsoid::wgs84().a_over_b(), a = Ellipsoid::wgs84().a_m;
    const dvec3 moon = sky.moon.dir_ecef * sky.moon.distance_m, axis = -sky.moon.sun_from_moon_ecef;
    const dvec3 o(moon.x, moon.y, moon.z * s), d(axis.x, axis.y, axis.z * s);
    const double dd = glm::dot(d, d), od = glm::dot(o, d), det = od * od - dd * (glm::dot(o, o) - a * a);
    REQUIRE(det > 0.0);
    totals.push_back({time, at_sea_level(moon + axis * ((-od - std::sqrt(det)) / dd))});
  }
  {
    // 43.5 N, 3.8 W lies in the path of totality: when?
    const Geodetic santander = Geodetic::from_degrees(43.5, -3.8, 10.0);
    const UtcInstant start = parse_utc("2026-08-12T18:15:00Z");
    double least = 1e9, shadow = 0.0;
    UtcInstant when = start;
    for (int i = 0; i < 360; ++i) {
      const UtcInstant t = start.plus_seconds(5.0 * i);
      const SkyBodies sky = sky_bodies_at(t);
      const dvec3 from = ecef_from_geodetic(santander);
      const dvec3 to_moon = sky.moon.dir_ecef * sky.moon.distance_m - from;
      const dvec3 to_sun = sky.sun.dir_ecef * (sky.sun.distance_au * kAstronomicalUnit_m) - from;
      const double apart = glm::length(glm::normalize(to_moon) - glm::normalize(to_sun));
      if (apart >= least) continue;
      least = apart;
      when = t;
      shadow = std::asin(kMoonRadius_m / glm::length(to_moon)) - std::asin(kSunRadius_m / glm::length(to_sun));
    }
    MESSAGE("in Cantabria: total around " << format_utc(when) << ", centres " << 206265.0 * least
                                          << " arc seconds apart of " << 206265.0 * shadow);
    CHECK(least < shadow);
    totals.push_back({format_utc(when), santander});
  }
  for (const Total& total : totals) {
    // What is brighter where the sun is than just beside it: of the sky's own glow a part is left.
    constexpr uint32_t kSize = 96;
    double excess[2] = {0.0, 0.0};
    for (const int hour_before : {0, 1}) {
      Scene scene = small_scene(kSize, kSize);
      const UtcInstant t = parse_utc(total.time).plus_seconds(-3600.0 * hour_before);
      scene.time = format_utc(t);
      const SkyBodies sky = sky_bodies_at(t);
      scene.camera.lat_deg = deg_from_rad(total.at.lat_rad);
      scene.camera.lon_deg = deg_from_rad(total.at.lon_rad);
      scene.camera.height_m = total.at.height_m;
      scene.camera.fov_deg = 0.8;
      aim(scene, horizontal_from_ecef(total.at, sky.sun.dir_ecef, sky.sun.distance_au * kAstronomicalUnit_m));
      const Picture p = draw(gpu.device, scene);
      CHECK(p.not_positive() == 0);
      const double radius_px = sky.sun.angular_radius_rad / rad_from_deg(scene.camera.fov_deg) * kSize;
      double inside = 0.0, beside = 0.0;
      int inside_count = 0, beside_count = 0;
      for (size_t y = 0; y < kSize; ++y)
        for (size_t x = 0; x < kSize; ++x) {
          const double middle = 0.5 * (kSize - 1);
          const double r = std::hypot(static_cast<double>(x) - middle, static_cast<double>(y) - middle) / radius_px;
          if (r < 1.1) inside += luminance(p.at(x, y)), ++inside_count;
          if (r > 1.25 && r < 1.45) beside += luminance(p.at(x, y)), ++beside_count;
        }
      excess[hour_before] = inside / inside_count - beside / beside_count;
      MESSAGE(scene.time << " at " << scene.camera.lat_deg << ", " << scene.camera.lon_deg << ": sun "
                         << inside / inside_count << " cd/m2, beside it " << beside / beside_count);
    }
    CHECK(excess[1] > 1e6);
    CHECK(std::abs(excess[0]) < 3e-4 * excess[1]);  // what smoothed edges let through
  }
}
