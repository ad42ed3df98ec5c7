// Air and light at points by the air volume against the exact functions.
#include <algorithm>
#include <cmath>
#include <random>

#include "astro/utc_time.h"
#include "atmosphere/air_volume.h"
#include "atmosphere/luminance.h"
#include "gpu/commands.h"
#include "gpu/gpu_fixture.h"
#include "render/air_volume_test.comp.h"
#include "render/frame_setup.h"

using namespace nepho;

namespace {

constexpr double kTop_m = 16e3;

struct Place {
  glm::vec2 pixel;
  float distance_m;
};
struct Answer {
  glm::vec3 air, through, key, sky;
};

/// Points of a picture between the camera and the ground or kTop_m, as many in every decade of distance.
std::vector<Place> places_of(const shared::FrameConstants& frame, size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> share(0.0f, 1.0f);
  std::vector<Place> places;
  while (places.size() < count) {
    const glm::vec2 pixel = glm::vec2(share(random), share(random)) * glm::vec2(frame.size);
    const glm::vec3 dir = shared::pixel_direction(frame, pixel);
    glm::vec2 sea(0.0f), top(0.0f);
    const bool down = shared::intersect_shell(frame.planet, dir, 0.0f, sea) && sea.x > 0.0f;
    if (!shared::intersect_shell(frame.planet, dir, static_cast<float>(kTop_m), top)) continue;
    if (!down && top.y <= 0.0f) continue;
    const float far_m = down ? sea.x : top.y, near_m = std::min(100.0f, far_m);
    places.push_back({pixel, near_m * std::pow(far_m / near_m, std::sqrt(share(random)))});
  }
  return places;
}

struct View {
  const char* name;
  const char* time;
  double height_m, heading_deg, pitch_deg;
  double most_air = 0.003;  ///< of 95 in 100 points
};

/// Errors, greatest channel, of the 95th percentile and the worst.
struct Errors {
  std::vector<double> of;
  double at(double share) {
    std::sort(of.begin(), of.end());
    return of[static_cast<size_t>(share * static_cast<double>(of.size() - 1))];
  }
};

double brightest(const glm::vec3& c) { return static_cast<double>(std::max({c.r, c.g, c.b})); }
double relative(const glm::vec3& exact, const glm::vec3& quick) {
  return brightest(glm::abs(quick - exact)) / std::max(brightest(exact), 1e-12);
}

}  // namespace

TEST_CASE("gpu: the air volume is the air that is integrated, within 0.3 % (0.8 % under a low sun)") {
  GpuFixture gpu;
  const AtmosphereParams params;
  const AtmosphereTables tables(gpu.device, params);
  const AirVolume volume(gpu.device, tables.spectral_groups());
  const gpu::ComputePipeline pipeline(
      gpu.device, {.name = "air_volume_test", .spirv = air_volume_test_comp, .constants = {tables.spectral_groups()}});
  // Noon, the sun at 10, 2.3 and 0.7 degrees, and night with a moon. Near the ground under a low sun the table of
  // columns, which is even in the root of the height, decides.
  for (const View& view : {View{"noon, 2 m", "2026-03-20T03:00:00Z", 2.0, 180.0, 2.0},
                           View{"noon, 1.5 km, down", "2026-03-20T03:00:00Z", 1500.0, 60.0, -20.0},
                           View{"noon, 10 km", "2026-03-20T03:00:00Z", 10e3, 300.0, -15.0},
                           View{"noon, 16 km, straight down", "2026-03-20T03:00:00Z", 16e3, 0.0, -90.0},
                           View{"noon, zenith", "2026-03-20T03:00:00Z", 500.0, 0.0, 90.0},
                           View{"evening, 500 m, to the sun", "2026-03-20T08:00:00Z", 500.0, 262.0, 4.0, 0.005},
                           View{"evening, 10 km, to the sun", "2026-03-20T08:00:00Z", 10e3, 262.0, -4.0},
                           View{"low sun, 2 m", "2026-03-20T08:38:00Z", 2.0, 250.0, 4.0, 0.008},
                           View{"low sun, 1.5 km", "2026-03-20T08:38:00Z", 1500.0, 90.0, -4.0},
                           View{"sunset, 10 km", "2026-03-20T08:46:00Z", 10e3, 250.0, -4.0, 0.005},
                           View{"night, 1 km", "2026-04-02T13:00:00Z", 1000.0, 150.0, 0.0}}) {
    CameraParams camera;
    camera.lat_deg = 35.7;
    camera.lon_deg = 139.4;
    camera.height_m = view.height_m;
    camera.heading_deg = view.heading_deg;
    camera.pitch_deg = view.pitch_deg;
    camera.fov_deg = 60.0;
    const UtcInstant utc = parse_utc(view.time);
    const FrameLight light = FrameLight::from(sky_bodies_at(utc), sun_illuminance_at_1au(params), true);
    FrameInfo frame;
    frame.extent = {640, 360};
    frame.constants = make_frame_constants(resolve_camera(camera, [](double, double) { return 0.0; }), frame.extent,
                                           light, utc.seconds_since_2000(), 0, 0, glm::vec2(0.0f));
    FrameGraph graph;
    frame.buffer = graph.constants("frame", frame.constants);
    REQUIRE(AirVolume::serves(tables.uniform(), frame.constants, kTop_m));
    const std::vector<Place> places = places_of(frame.constants, 4000);
    const AtmosphereTables::Refs refs = tables.add(graph, {});
    const AirVolume::Refs air = volume.add(graph, frame, tables, refs, kTop_m);
    const BufferRef out = graph.create_buffer("answers", 2 * places.size() * sizeof(Answer));
    auto pass = graph.pass("air_volume_test");
    pass.uniform("frame", frame.buffer).read("places", graph.constants("places", places)).write("answers", out);
    AtmosphereTables::bind(pass, refs);
    AirVolume::bind(graph, pass, air, refs);
    pass.record([&](gpu::Commands& cmd) { cmd.bind(pipeline).dispatch_threads(static_cast<uint32_t>(places.size())); });
    graph.keep(out);
    gpu.executor.run(graph);
    const std::vector<Answer> answers = gpu.executor.read<Answer>(out);
    Errors luminance, through, key, sky;
    double most_key = 0.0;
    for (size_t i = 0; i < places.size(); ++i) most_key = std::max(most_key, brightest(answers[2 * i].key));
    for (size_t i = 0; i < places.size(); ++i) {
      const Answer &exact = answers[2 * i], &quick = answers[2 * i + 1];
      luminance.of.push_back(relative(exact.air, quick.air));
      through.of.push_back(brightest(glm::abs(quick.through - exact.through)));
      key.of.push_back(brightest(glm::abs(quick.key - exact.key)) / std::max(most_key, 1e-12));
      sky.of.push_back(relative(exact.sky, quick.sky));
    }
    MESSAGE(std::string(view.name), ", %, median, of 95 in 100 and worst: air ", 100 * luminance.at(0.5), " ",
            100 * luminance.at(0.95), " ", 100 * luminance.at(1.0), ", transmittance ", 100 * through.at(0.5), " ",
            100 * through.at(0.95), " ", 100 * through.at(1.0), ", key light ", 100 * key.at(1.0), ", sky light ",
            100 * sky.at(1.0));
    CHECK(luminance.at(0.95) < view.most_air);
    CHECK(through.at(0.95) < 0.003);
    CHECK(through.at(1.0) < 0.012);
    CHECK(key.at(1.0) < 0.003);
    CHECK(sky.at(1.0) < 0.003);
  }
}

TEST_CASE("at dusk and high up there is no air volume") {
  const AtmosphereConstants air = make_atmosphere_constants({});
  const auto served = [&](const char* time, double height_m) {
    CameraParams camera;
    camera.lat_deg = 35.7;
    camera.lon_deg = 139.4;
    camera.height_m = height_m;
    const UtcInstant utc = parse_utc(time);
    const FrameLight light = FrameLight::from(sky_bodies_at(utc), glm::vec3(1e5f), true);
    return AirVolume::serves(air.data.air,
                             make_frame_constants(resolve_camera(camera, [](double, double) { return 0.0; }), {64, 36},
                                                  light, 0.0, 0, 0, glm::vec2(0.0f)),
                             kTop_m);
  };
  CHECK(served("2026-03-20T03:00:00Z", 2.0));
  CHECK(served("2026-03-20T13:00:00Z", 2.0));
  CHECK_FALSE(served("2026-03-20T09:08:00Z", 2.0));
  CHECK_FALSE(served("2026-03-20T03:00:00Z", 400e3));
}
