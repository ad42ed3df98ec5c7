// The light of a day goes on without jumps: minute by minute from sunset to deep night, and across every moment at
// which what is computed changes.
#include <algorithm>
#include <glm/geometric.hpp>

#include "render/frame_setup.h"
#include "render/night_sky.h"
#include "render/reference_scene.h"

namespace nepho {
namespace {
using namespace test;

/// Sunset at 36 degrees north, 140 east; a gibbous moon stands in the east, 32 degrees high.
constexpr const char* kEvening = "2026-12-21T07:25:00Z";

struct Place {
  const char* name;
  double height_m, pitch_deg, fov_deg;
};
const Place kPlaces[] = {{"ground", 400.0, 12.0, 60.0}, {"orbit", 400e3, -50.0, 60.0}};

Scene evening(const Place& place, const std::string& light) {
  Scene scene = reference_scene(half_sky("cumulus", 0.4), {48, 27});
  scene.time = kEvening;
  scene.camera.lat_deg = 36.0;
  scene.camera.lon_deg = 140.0;
  scene.camera.height_m = place.height_m;
  scene.camera.heading_deg = 90.0;  // towards the moon and the coming night
  scene.camera.pitch_deg = place.pitch_deg;
  scene.camera.fov_deg = place.fov_deg;
  scene.clouds.layers[0].wind_east_mps = scene.clouds.layers[0].wind_north_mps = 0.0;
  scene.clouds.layers[0].evolution_speed = 0.0;
  scene.clouds.multiple_scattering = light;
  scene.clouds.shadows.cascades = 1;  // all of them are made anew each minute
  scene.clouds.shadows.resolution = 128;
  scene.shafts.method = "shadow-length";
  scene.render.quality = "medium";
  scene.render.frames = 1;
  return scene;
}

/// log2 of the luminance of every pixel, cd/m2, at a moment.
std::vector<double> log_luminance(Renderer& renderer, const UtcInstant& at,
                                  const std::optional<UtcInstant>& sky = std::nullopt) {
  renderer.set_time(at, sky);
  RenderRequest request;
  request.display = false;
  request.wanted = {"R", "G", "B"};
  const ImageBuffer picture = renderer.render(request).layers;
  const std::vector<float>&r = channel(picture, "R"), &g = channel(picture, "G"), &b = channel(picture, "B");
  std::vector<double> sum;
  for (size_t i = 0; i < r.size(); ++i) {
    const double y =
        0.2126 * static_cast<double>(r[i]) + 0.7152 * static_cast<double>(g[i]) + 0.0722 * static_cast<double>(b[i]);
    sum.push_back(std::log2(std::max(y, 1e-12)));
  }
  return sum;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double mean_apart(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / static_cast<double>(a.size());
}

double largest_apart(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0.0;
  for (size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

shared::FrameConstants constants_at(const Renderer& renderer, const UtcInstant& at) {
  const FrameLight light = FrameLight::from(sky_bodies_at(at), vec3(1.3e5f), true);
  return make_frame_constants(renderer.pose(), {48, 27}, light, at.seconds_since_2000(), 0, 0, glm::vec2(0.0f));
}

/// What a frame computes: changes of it are changes of code, not of light.
int branch_at(const Renderer& renderer, const UtcInstant& at) {
  const shared::FrameConstants c = constants_at(renderer, at);
  return static_cast<int>(c.light_count) + (c.key_dir == c.moon_dir ? 4 : 0) + (NightSky::shows(c) ? 8 : 0);
}

/// Seconds after a moment at which the branch changes, to half a second, in the minute from there.
double change_in_minute(const Renderer& renderer, const UtcInstant& from) {
  const int before = branch_at(renderer, from);
  double low = 0.0, high = 60.0;
  while (high - low > 0.5) {
    const double middle = 0.5 * (low + high);
    (branch_at(renderer, from.plus_seconds(middle)) == before ? low : high) = middle;
  }
  return high;
}

/// The sun sinks by at most 0.25 degrees a minute, and twilight falls by at most 1.45 stops a degree (3.4 lux at -6
/// degrees, 0.008 at -12: log2(425) / 6): no picture may change faster.
constexpr double kMostPerMinute = 0.25 * 1.45;

TEST_CASE("gpu: nothing jumps where moon and night sky come in and where the moon takes over shadows from the sun") {
  GpuFixture gpu;
  for (const Place& place : kPlaces) {
    Renderer renderer(gpu.device, {}, evening(place, "octaves"));
    const UtcInstant sunset = parse_utc(kEvening);
    int changes = 0;
    for (int m = 0; m < 180; ++m) {
      const UtcInstant at = sunset.plus_seconds(60.0 * m);
      if (branch_at(renderer, at) == branch_at(renderer, at.plus_seconds(60.0))) continue;
      ++changes;
      const double after_s = change_in_minute(renderer, at);
      const std::vector<double> before = log_luminance(renderer, at.plus_seconds(after_s - 0.5));
      const std::vector<double> after = log_luminance(renderer, at.plus_seconds(after_s + 0.5));
      MESSAGE(place.name, ", minute ", m, ": mean change in a second ", mean_apart(before, after), " stops, at most ",
              largest_apart(before, after));
      CHECK(mean_apart(before, after) < kMostPerMinute / 60.0);
      CHECK(largest_apart(before, after) < 0.05);
    }
    CHECK(changes == (place.height_m > 1e5 ? 2 : 3));  // from space stars are always drawn
  }
}

// The measure is the second difference, minute by minute: a jump of so many stops would be one of so many. Twilight's
// slope goes from 1.45 stops a degree to none under the moon's light within some 3 degrees, 16 minutes of 0.2: 0.018 a
// minute squared; a smoothstep over 20 minutes of one stop bends by at most 6 / 20^2 = 0.015.
TEST_CASE("gpu: while the moon takes over from the sun consecutive minutes differ smoothly") {
  GpuFixture gpu;
  Renderer renderer(gpu.device, {}, evening(kPlaces[0], "octaves"));
  const UtcInstant start = parse_utc(kEvening).plus_seconds(60.0 * 46.0);  // the sun at -8.4 degrees
  std::vector<double> level;
  std::string told;
  for (int m = 0; m <= 26; ++m) {
    level.push_back(mean(log_luminance(renderer, start.plus_seconds(60.0 * m))));
    told += std::to_string(level.back()) + " ";
  }
  MESSAGE(told);
  for (size_t i = 1; i < level.size(); ++i) {
    CAPTURE(i);
    CHECK(std::abs(level[i] - level[i - 1]) < kMostPerMinute);
    if (i > 1) CHECK(std::abs(level[i] - 2.0 * level[i - 1] + level[i - 2]) < 0.03);
  }
}

/// The moment of 2026 at which the sun stands where the moon stands at another, from the Earth's centre.
UtcInstant sun_in_place_of(const dvec3& dir) {
  const auto apart = [&](const UtcInstant& at) { return glm::length(sky_bodies_at(at).sun.dir_ecef - dir); };
  UtcInstant best = parse_utc("2026-01-01");
  const auto search = [&](const UtcInstant& from, double step_s, int count, const auto& far) {
    UtcInstant found = from;
    for (int i = 1; i < count; ++i)
      if (far(from.plus_seconds(i * step_s)) < far(found)) found = from.plus_seconds(i * step_s);
    return found;
  };
  best = search(best, 86400.0, 170,
                [&](const UtcInstant& at) { return std::abs(sky_bodies_at(at).sun.dir_ecef.z - dir.z); });
  return search(best.plus_seconds(-43200.0), 30.0, 2880, apart);
}

TEST_CASE("gpu: full moonlight on clouds and ground is sunlight from its place, dimmed") {
  GpuFixture gpu;
  Scene scene = evening(kPlaces[0], "octaves");
  scene.night_sky.airglow_cd_m2 = 0.0;
  Renderer renderer(gpu.device, {}, scene);
  const UtcInstant night = parse_utc("2026-10-26T12:30:00Z");
  const SkyBodies sky = sky_bodies_at(night);
  const shared::FrameConstants moonlit = constants_at(renderer, night);
  REQUIRE(moonlit.key_dir == moonlit.moon_dir);
  const UtcInstant day = sun_in_place_of(dvec3(moonlit.moon_dir));
  const shared::FrameConstants sunlit = constants_at(renderer, day);
  REQUIRE(glm::length(sunlit.sun_dir - moonlit.moon_dir) < 0.01f);
  CHECK(sky.moon.illuminated_fraction > 0.98);
  const vec3 share = moonlit.moon_share / sunlit.sun_distance_factor;
  const double expected = std::log2(static_cast<double>(0.2126f * share.x + 0.7152f * share.y + 0.0722f * share.z));
  const std::vector<double> by_moon = log_luminance(renderer, night), by_sun = log_luminance(renderer, night, day);
  const std::vector<double> aside = log_luminance(renderer, night, day.plus_seconds(6.0 * 3600.0));
  const auto spread = [&](const std::vector<double>& light) {
    double sum = 0.0;
    const double level = mean(light) - mean(by_moon);
    for (size_t i = 0; i < light.size(); ++i) sum += std::abs(light[i] - by_moon[i] - level);
    return sum / static_cast<double>(light.size());
  };
  MESSAGE("moon less sun: ", mean(by_moon) - mean(by_sun), " stops, of ", expected, "; spread ", spread(by_sun),
          ", of a sun elsewhere ", spread(aside));
  CHECK(mean(by_moon) - mean(by_sun) == doctest::Approx(expected).epsilon(0.005));
  CHECK(spread(by_sun) < 0.03);
  CHECK(spread(aside) > 0.3);
}

}  // namespace
}  // namespace nepho
