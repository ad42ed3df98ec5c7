#pragma once
#include <optional>

#include "clouds/cloud_test_tools.h"
#include "clouds/shadow_map.h"
#include "clouds/shadow_map_test.comp.h"
#include "geo/planet_view.h"
#include "gpu/commands.h"

namespace nepho::test {

struct ShadowView {
  double lat_deg = 34.9, lon_deg = 138.1, height_m = 1700.0, heading_deg = 0.0, pitch_deg = -2.0, fov_deg = 45.0;
  double sun_elevation_deg = 60.0, sun_azimuth_deg = 140.0;
  uint32_t width = 256, height = 144;
  double east_m = 0.0, north_m = 0.0;  ///< camera moved so far
  double time_s = kQuietTime_s;
};

inline FrameInfo frame_of(const ShadowView& view) {
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

struct ShadowAnswer {
  float truth, by_map, sigma_per_m;
  uint32_t steps;
};

/// Shadow maps of one sky, and what there is to be asked.
struct ShadowRig {
  ShadowRig(GpuFixture& fixture, const CloudParams& params, const CloudShadowParams& shadows = {})
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
  void update(const ShadowView& view) {
    FrameGraph graph;
    FrameInfo frame = frame_of(view);
    frame.buffer = graph.constants("frame", frame.constants);
    maps.add(graph, frame, import_cloud_density(graph, frame, clouds));
    gpu.executor.run(graph);
  }
  std::vector<ShadowAnswer> ask(const ShadowView& view, const std::vector<glm::vec3>& points, float step_m) {
    FrameGraph graph;
    FrameInfo frame = frame_of(view);
    frame.buffer = graph.constants("frame", frame.constants);
    const CloudDensityRefs density = import_cloud_density(graph, frame, clouds);
    const CloudShadowRefs refs = maps.add(graph, frame, density);
    REQUIRE(!points.empty());
    const BufferRef out = graph.create_buffer("answers", points.size() * sizeof(ShadowAnswer));
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
    return gpu.executor.read<ShadowAnswer>(out);
  }
  GpuFixture& gpu;
  Clouds clouds;
  CloudShadowMaps maps;
  gpu::ComputePipeline probe;
};

/// Points of the ground in view, by pixels at random, up to the shadows' reach.
inline std::vector<glm::vec3> ground_points(const ShadowView& view, size_t count, float reach_m) {
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
inline std::vector<glm::vec3> cloud_points(ShadowRig& rig, const ShadowView& view, size_t count, float reach_m) {
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
    const std::vector<ShadowAnswer> answers = rig.ask(view, some, 0.0f);
    for (size_t i = 0; i < some.size(); ++i)
      if (answers[i].sigma_per_m > 1e-3f && points.size() < count) points.push_back(some[i]);
  }
  return points;
}

struct Errors {
  double mean_abs = 0.0, bias = 0.0, mean_truth = 0.0, steps = 0.0;
  size_t count = 0;
};

inline Errors errors_of(const std::vector<ShadowAnswer>& answers) {
  Errors e;
  e.count = answers.size();
  for (const ShadowAnswer& a : answers) {
    const double d = static_cast<double>(a.by_map) - static_cast<double>(a.truth);
    e.mean_abs += std::abs(d);
    e.bias += d;
    e.mean_truth += static_cast<double>(a.truth);
    e.steps += a.steps;
  }
  const double n = std::max<double>(1.0, static_cast<double>(e.count));
  return {e.mean_abs / n, e.bias / n, e.mean_truth / n, e.steps / n, e.count};
}

inline CloudParams cumulus() {
  CloudParams params;
  params.coverage = 0.5;
  params.layers[0].base_m = 1000.0;
  params.layers[0].thickness_m = 1400.0;
  return params;
}

}  // namespace nepho::test
