#include <optional>

#include "clouds/cloud_test_tools.h"
#include "clouds/shadow_map.h"
#include "clouds/shadow_map_test.comp.h"
#include "geo/planet_view.h"
#include "gpu/commands.h"

namespace nepho {
namespace {
using namespace test;

struct View {
  double lat_deg = 34.9, lon_deg = 138.1, height_m = 1700.0, heading_deg = 0.0, pitch_deg = -2.0, fov_deg = 45.0;
  double sun_elevation_deg = 60.0, sun_azimuth_deg = 140.0;
  uint32_t width = 256, height = 144;
  double east_m = 0.0, north_m = 0.0;  ///< camera moved so far
  double time_s = kQuietTime_s;
};

FrameInfo frame_of(const View& view) {
  const Geodetic place = Geodetic::from_degrees(view.lat_deg, view.lon_deg, view.height_m);
  const dmat4 ecef_from_enu = make_ecef_from_enu(place);
  const auto direction = [&](double heading, double pitch) {
    const double h = rad_from_deg(heading), p = rad_from_deg(pitch);
    return dvec3(ecef_from_enu * glm::dvec4(std::sin(h) * std::cos(p), std::cos(h) * std::cos(p), std::sin(p), 0.0));
  };
  FrameInfo frame;
  frame.extent = {view.width, view.height};
  frame.camera_ecef_m = dvec3(ecef_from_enu * glm::dvec4(view.east_m, view.north_m, 0.0, 1.0));
  frame.time_s = view.time_s;
  shared::FrameConstants& c = frame.constants = {};
  c.planet = make_planet_view(frame.camera_ecef_m);
  const double tan_y = std::tan(0.5 * rad_from_deg(view.fov_deg)), tan_x = tan_y * view.width / view.height;
  const dvec3 forward = direction(view.heading_deg, view.pitch_deg),
              up = direction(view.heading_deg, view.pitch_deg + 90.0);
  c.forward = glm::vec3(forward);
  c.right = glm::vec3(cross(forward, up) * tan_x);
  c.up = glm::vec3(up * tan_y);
  c.pixel_angle_rad = static_cast<float>(2.0 * tan_y / view.height);
  c.camera_up = glm::vec3(direction(0.0, 90.0));
  c.key_dir = c.sun_dir = glm::vec3(direction(view.sun_azimuth_deg, view.sun_elevation_deg));
  c.size = {view.width, view.height};
  return frame;
}

struct Answer {
  float truth, by_map, sigma_per_m;
  uint32_t steps;
};

/// Shadow maps of one sky, and what there is to be asked.
struct Rig {
  Rig(GpuFixture& fixture, const CloudParams& params, const CloudShadowParams& shadows = {})
      : gpu(fixture),
        clouds(gpu.device, params),
        maps(gpu.device, clouds, shadows),
        probe(gpu.device,
              {.name = "shadow_test", .spirv = shadow_map_test_comp, .constants = clouds.specialisation(2)}) {}
  /// Passes of the last frame whose names begin so.
  size_t passes(const std::string& name) const {
    size_t count = 0;
    for (const gpu::PassTiming& t : gpu.executor.timings()) count += t.name.starts_with(name) ? 1 : 0;
    return count;
  }
  void update(const View& view) {
    FrameGraph graph;
    FrameInfo frame = frame_of(view);
    frame.buffer = graph.constants("frame", frame.constants);
    maps.add(graph, frame, import_cloud_density(graph, frame, clouds));
    gpu.executor.run(graph);
  }
  std::vector<Answer> ask(const View& view, const std::vector<glm::vec3>& points, float step_m) {
    FrameGraph graph;
    FrameInfo frame = frame_of(view);
    frame.buffer = graph.constants("frame", frame.constants);
    const CloudDensityRefs density = import_cloud_density(graph, frame, clouds);
    const CloudShadowRefs refs = maps.add(graph, frame, density);
    REQUIRE(!points.empty());
    const BufferRef out = graph.create_buffer("answers", points.size() * sizeof(Answer));
    auto pass = graph.pass("shadow_test");
    pass.uniform("frame", frame.buffer).read("points", graph.constants("points", points)).write("answers", out);
    bind_density(pass, density);
    bind_cloud_shadow(pass, refs);
    struct Push {
      uint32_t count;
      float step_m;
    } push{static_cast<uint32_t>(points.size()), step_m};
    pass.record([this, push](gpu::Commands& cmd) { cmd.bind(probe).push(push).dispatch_threads(push.count); });
    graph.keep(out);
    gpu.executor.run(graph);
    return gpu.executor.read<Answer>(out);
  }
  GpuFixture& gpu;
  Clouds clouds;
  CloudShadowMaps maps;
  gpu::ComputePipeline probe;
};

/// Points of the ground in view, by pixels at random, up to the shadows' reach.
std::vector<glm::vec3> ground_points(const View& view, size_t count, float reach_m) {
  const FrameInfo frame = frame_of(view);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  std::vector<glm::vec3> points;
  for (size_t i = 0; i < 400 * count && points.size() < count; ++i) {
    const glm::vec2 pixel(unit(random) * static_cast<float>(view.width),
                          unit(random) * static_cast<float>(view.height));
    const glm::vec3 dir = shared::pixel_direction(frame.constants, pixel);
    glm::vec2 t(0.0f);
    if (shared::intersect_shell(frame.constants.planet, dir, 0.0f, t) && t.x > 0.0f && t.x < reach_m)
      points.push_back(dir * t.x);
  }
  return points;
}

/// Points inside clouds in view: anywhere along rays at random.
std::vector<glm::vec3> cloud_points(Rig& rig, const View& view, size_t count, float reach_m) {
  const FrameInfo frame = frame_of(view);
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  std::vector<glm::vec3> points;
  const float high = rig.maps.data().hull_high_m, low = rig.maps.data().hull_low_m;
  for (int round = 0; round < 60 && points.size() < count; ++round) {
    std::vector<glm::vec3> some;
    for (int i = 0; i < 400000 && some.size() < 4096; ++i) {
      const glm::vec2 pixel(unit(random) * static_cast<float>(view.width),
                            unit(random) * static_cast<float>(view.height));
      const glm::vec3 dir = shared::pixel_direction(frame.constants, pixel);
      glm::vec2 ground(0.0f);
      float from = 0.0f, to = reach_m;
      if (shared::intersect_shell(frame.constants.planet, dir, 0.0f, ground) && ground.x > 0.0f)
        to = std::min(to, ground.x);
      glm::vec2 top(0.0f);
      if (!shared::intersect_shell(frame.constants.planet, dir, high, top)) continue;
      from = std::max(from, top.x);
      to = std::min(to, top.y);
      if (to <= from) continue;
      const glm::vec3 p = dir * (from + (to - from) * unit(random));
      const float h = shared::geodetic_height(frame.constants.planet, p);
      if (h > low && h < high) some.push_back(p);
    }
    const std::vector<Answer> answers = rig.ask(view, some, 0.0f);
    for (size_t i = 0; i < some.size(); ++i)
      if (answers[i].sigma_per_m > 1e-3f && points.size() < count) points.push_back(some[i]);
  }
  return points;
}

struct Errors {
  double mean_abs = 0.0, bias = 0.0, mean_truth = 0.0, steps = 0.0;
  size_t count = 0;
};

Errors errors_of(const std::vector<Answer>& answers) {
  Errors e;
  e.count = answers.size();
  for (const Answer& a : answers) {
    const double d = static_cast<double>(a.by_map) - static_cast<double>(a.truth);
    e.mean_abs += std::abs(d);
    e.bias += d;
    e.mean_truth += static_cast<double>(a.truth);
    e.steps += a.steps;
  }
  const double n = std::max<double>(1.0, static_cast<double>(e.count));
  return {e.mean_abs / n, e.bias / n, e.mean_truth / n, e.steps / n, e.count};
}

CloudParams cumulus() {
  CloudParams params;
  params.coverage = 0.5;
  params.layers[0].base_m = 1000.0;
  params.layers[0].thickness_m = 1400.0;
  return params;
}

/// Everything that CHECK_errors() looks at.
struct Accuracy {
  Errors ground, inside;
};

Accuracy measure(Rig& rig, const View& view, size_t count) {
  const float reach = rig.maps.data().at[rig.maps.data().cascades - 1].fade_m;
  constexpr float kTrueStep_m = 3.0f;
  Accuracy a;
  a.ground = errors_of(rig.ask(view, ground_points(view, count, reach), kTrueStep_m));
  a.inside = errors_of(rig.ask(view, cloud_points(rig, view, count, reach), kTrueStep_m));
  return a;
}

void check_accuracy(const Accuracy& a, size_t count, const std::string& what) {
  MESSAGE(what << ": ground " << a.ground.count << " points, mean |d| " << a.ground.mean_abs << ", bias "
               << a.ground.bias << ", true mean " << a.ground.mean_truth << "; inside " << a.inside.count
               << " points, mean |d| " << a.inside.mean_abs << ", bias " << a.inside.bias << ", true mean "
               << a.inside.mean_truth);
  CHECK(a.ground.count == count);
  CHECK(a.inside.count == count);
  // Of 300 points the mean of errors with a spread of 0.09 is known to 0.005: twice that is added to the bounds.
  const double unsure = full_size() ? 0.0 : 0.01;
  CHECK(a.ground.mean_abs <= 0.03 + unsure);
  CHECK(a.inside.mean_abs <= 0.06 + unsure);
  CHECK(std::abs(a.ground.bias) <= 0.015 + unsure);
  CHECK(std::abs(a.inside.bias) <= 0.015 + unsure);
}

TEST_CASE("gpu: shadow maps are within 0.03 of a fine march on the ground, within 0.06 inside clouds, bias 0.015") {
  GpuFixture gpu;
  const size_t count = full_size() ? 10000 : 300;
  Rig rig(gpu, cumulus());
  for (const double elevation : full_size() ? std::vector<double>{60.0, 30.0, 10.0} : std::vector<double>{60.0}) {
    View view;
    view.sun_elevation_deg = elevation;
    rig.update(view);
    check_accuracy(measure(rig, view, count), count, fmt::format("sun {} deg", elevation));
  }
  // The mean of several marches of the same maps is no worse.
  View view;
  for (int i = 0; i < 20; ++i) rig.update(view);
  CHECK(rig.maps.work().marched == 0);
  check_accuracy(measure(rig, view, count), count, "sun 60 deg, resolved");
}

TEST_CASE("gpu: a shadow's edge on the ground is within a texel of the true one") {
  GpuFixture gpu;
  Rig rig(gpu, cumulus());
  const View view;
  rig.update(view);
  const shared::ShadowMaps& d = rig.maps.data();
  const FrameInfo frame = frame_of(view);
  // Lines across the ground in the first cascade, points a quarter of a texel apart.
  const float texel = d.at[0].texel_m;
  constexpr int kHalf = 24;
  const std::vector<glm::vec3> middles = ground_points(view, full_size() ? 4000 : 500, d.at[0].fade_m);
  std::vector<glm::vec3> points;
  for (const glm::vec3& middle : middles) {
    const glm::vec3 up = shared::geodetic_up(frame.constants.planet, middle);
    const glm::vec3 along = normalize(cross(up, glm::vec3(0.3f, -0.5f, 0.8f)));  // across the light, nearly
    for (int i = -kHalf; i <= kHalf; ++i) points.push_back(middle + along * (0.25f * texel * static_cast<float>(i)));
  }
  const std::vector<Answer> answers = rig.ask(view, points, 3.0f);
  // Where the light first passes half, between two points.
  const auto crossing = [&](size_t line, bool truth) -> std::optional<double> {
    const size_t first = line * (2 * kHalf + 1);
    const auto value = [&](int i) {
      const Answer& a = answers[first + static_cast<size_t>(i)];
      return static_cast<double>(truth ? a.truth : a.by_map);
    };
    std::optional<double> at;
    for (int i = 0; i < 2 * kHalf; ++i) {
      if ((value(i) - 0.5) * (value(i + 1) - 0.5) >= 0.0) continue;
      if (at) return std::nullopt;  // more than one edge
      at = 0.25 * (i + (0.5 - value(i)) / (value(i + 1) - value(i)));
    }
    return at;
  };
  std::vector<double> off;
  for (size_t line = 0; line < middles.size(); ++line) {
    const auto truth = crossing(line, true), map = crossing(line, false);
    if (truth && map) off.push_back(std::abs(*map - *truth));
  }
  REQUIRE(off.size() > 15);
  std::sort(off.begin(), off.end());
  MESSAGE(off.size() << " edges: median " << off[off.size() / 2] << " texels off, 90 % within "
                     << off[off.size() * 9 / 10] << ", the worst " << off.back());
  CHECK(off[off.size() / 2] < 0.5);
  CHECK(off[off.size() * 9 / 10] < 1.0);
}

TEST_CASE("gpu: a camera that moves by a metre keeps its maps and the light on the ground") {
  GpuFixture gpu;
  CloudShadowParams shadows;
  shadows.rounds = 1;  // what is seen is the camera's doing alone
  Rig rig(gpu, cumulus(), shadows);
  View before;
  rig.update(before);
  const shared::ShadowMaps first = rig.maps.data();
  const std::vector<glm::vec3> points = ground_points(before, 400, first.at[2].reach_m);
  const std::vector<Answer> seen = rig.ask(before, points, 0.0f);
  View after = before;
  after.east_m = 0.8;
  after.north_m = 0.6;
  for (const bool anew : {false, true}) {  // kept maps, and maps made from the new place
    if (anew) rig.maps.reset();
    rig.update(after);
    const glm::vec3 moved(frame_of(after).camera_ecef_m - frame_of(before).camera_ecef_m);
    std::vector<glm::vec3> same;
    for (const glm::vec3& p : points) same.push_back(p - moved);
    const std::vector<Answer> now = rig.ask(after, same, 0.0f);
    double change = 0.0, sum = 0.0;
    for (size_t i = 0; i < points.size(); ++i) {
      change += static_cast<double>(std::abs(now[i].by_map - seen[i].by_map));
      sum += static_cast<double>(seen[i].by_map);
    }
    INFO(anew);
    CHECK(change < 0.005 * sum);
  }
}

/// A texel's corner from the Earth's centre in units of texels of its grid, along the plane's axes.
glm::dvec2 grid_place(const shared::ShadowMaps& d, uint32_t k, const FrameInfo& frame, const LightAxes& axes) {
  const glm::dvec3 corner = frame.camera_ecef_m + glm::dvec3(d.at[k].corner);
  return glm::dvec2(dot(corner, axes.x), dot(corner, axes.y)) / static_cast<double>(d.at[k].texel_m);
}

TEST_CASE("gpu: windows move by whole texels, and what stays in view keeps its bits") {
  GpuFixture gpu;
  Rig rig(gpu, cumulus());
  View view;
  rig.update(view);
  const shared::ShadowMaps first = rig.maps.data();
  const LightAxes axes = LightAxes::towards(glm::dvec3(first.light));
  const FrameInfo start = frame_of(view);
  const std::vector<std::byte> bits = gpu.device.download(rig.maps.image());
  const uint32_t all = rig.maps.work().marched;
  view.east_m = 237.0;
  view.north_m = -411.0;
  view.heading_deg = 1.0;
  // One round only: what is there already is not refined.
  rig.update(view);
  CHECK(rig.maps.work().marched < all / 2);
  const FrameInfo end = frame_of(view);
  for (uint32_t k = 0; k < first.cascades; ++k) {
    const shared::ShadowCascade &was = first.at[k], &is = rig.maps.data().at[k];
    CHECK(was.texel_m == is.texel_m);
    const glm::dvec2 shift = grid_place(rig.maps.data(), k, end, axes) - grid_place(first, k, start, axes);
    // Whole tiles, but for corners in single precision: 1e-7 of the way from the camera.
    const glm::dvec2 off = shift - round(shift / 8.0) * 8.0;
    CHECK(std::abs(off.x) < 2e-3);
    CHECK(std::abs(off.y) < 2e-3);
    // The storage place goes with the window.
    const glm::ivec2 steps(static_cast<int>(std::lround(shift.x)), static_cast<int>(std::lround(shift.y)));
    const int n = static_cast<int>(first.resolution);
    CHECK(static_cast<int>(is.first.x) == ((static_cast<int>(was.first.x) + steps.x) % n + n) % n);
    CHECK(static_cast<int>(is.first.y) == ((static_cast<int>(was.first.y) + steps.y) % n + n) % n);
  }
  CHECK(gpu.device.download(rig.maps.image()) != bits);
}

TEST_CASE("gpu: where nothing changes nothing is marched, and no bit changes; time makes maps anew, in slices") {
  GpuFixture gpu;
  CloudParams params = cumulus();
  params.layers[0].wind_east_mps = 10.0;
  CloudShadowParams shadows;
  shadows.rounds = 2;
  shadows.slices = 3;
  shadows.resolution = 128;
  Rig rig(gpu, params, shadows);
  View view;
  rig.update(view);
  const uint32_t needed = rig.maps.work().needed;
  REQUIRE(needed > 100);
  CHECK(rig.maps.work().marched == needed);
  CHECK(rig.passes("clouds.shadow") == 1);
  uint32_t more = 0;
  for (int i = 0; i < 3; ++i) {
    rig.update(view);
    CHECK(rig.maps.work().marched <= needed / 3 + 1);
    more += rig.maps.work().marched;
  }
  CHECK(more == needed);
  const std::vector<std::byte> bits = gpu.device.download(rig.maps.image());
  for (int i = 0; i < 3; ++i) {
    rig.update(view);
    CHECK(rig.maps.work().marched == 0);
    CHECK(rig.passes("clouds.shadow") == 0);
  }
  CHECK(gpu.device.download(rig.maps.image()) == bits);
  view.time_s += 0.1;  // a metre of wind: a share of them
  rig.update(view);
  CHECK(rig.maps.work().marched == (needed + 2) / 3);
  view.time_s += 600.0;  // they are all wrong
  rig.update(view);
  CHECK(rig.maps.work().marched == needed);
  view.sun_elevation_deg += 1.0;
  rig.update(view);
  CHECK(rig.maps.work().marched == rig.maps.work().needed);
}

TEST_CASE("gpu: no maps where they are turned off, nothing casts, or the layer is a slab") {
  GpuFixture gpu;
  const View view;
  for (int which = 0; which < 3; ++which) {
    CloudParams params = cumulus();
    CloudShadowParams shadows;
    if (which == 0) shadows.enabled = false;
    if (which == 1) params.layers[0].casts_shadow = false;
    if (which == 2) params.uniform_density = 0.1;
    Rig rig(gpu, params, shadows);
    for (const Answer& a : rig.ask(view, ground_points(view, 64, 20e3f), 0.0f)) CHECK(a.by_map == 1.0f);
    CHECK(rig.maps.work().needed == 0);
  }
}

}  // namespace
}  // namespace nepho
