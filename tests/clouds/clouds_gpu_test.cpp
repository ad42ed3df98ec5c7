#include <algorithm>
#include <cmath>
#include <functional>

#include "clouds/cloud_columns.h"
#include "clouds/cloud_march_pass.h"
#include "geo/frames.h"
#include "geo/planet_view.h"
#include "gpu/gpu_fixture.h"

namespace nepho {
namespace {

struct View {
  double lat_deg = 35.5, lon_deg = 138.7, height_m = 2.0, heading_deg = 40.0, pitch_deg = 20.0, fov_deg = 50.0;
  double sun_elevation_deg = 45.0;
  Extent2D size{64, 36};
};

struct Picture {
  std::vector<float> radiance, info;
  const float* at(uint32_t x, uint32_t y, uint32_t width) const { return &radiance[4 * (size_t{y} * width + x)]; }
};

struct CloudFixture : GpuFixture {
  CloudFixture()
      : atmosphere(device, air()),
        noise(device),
        weather(device, 256),
        march(device, atmosphere.spectral_groups()),
        columns(device) {}
  static AtmosphereParams air() {
    AtmosphereParams params;
    params.spectral = "fast";  // quicker to compute; nothing here depends on colours
    params.scattering_orders = 2;
    return params;
  }
  AtmosphereTables atmosphere;
  CloudNoise noise;
  WeatherMap weather;
  CloudMarchPass march;
  CloudColumns columns;

  FrameInfo frame_of(FrameGraph& graph, const View& v, double time_s = 0.0) {
    const Geodetic camera = Geodetic::from_degrees(v.lat_deg, v.lon_deg, v.height_m);
    const CameraAxes axes = camera_axes_ecef(camera, Attitude::from_degrees(v.heading_deg, v.pitch_deg));
    const double tangent = std::tan(rad_from_deg(v.fov_deg) / 2.0);
    FrameInfo frame;
    frame.extent = v.size;
    frame.camera_ecef_m = ecef_from_geodetic(camera);
    frame.time_s = time_s;
    shared::FrameConstants& c = frame.constants;
    c = {};
    c.planet = make_planet_view(frame.camera_ecef_m);
    c.forward = vec3(axes.forward);
    c.right = vec3(axes.right * (tangent * v.size.width / v.size.height));
    c.up = vec3(axes.up * tangent);
    c.pixel_angle_rad = static_cast<float>(2.0 * tangent / v.size.height);
    c.camera_up = vec3(geodetic_up_ecef(camera.lat_rad, camera.lon_rad));
    const double e = rad_from_deg(v.sun_elevation_deg);
    c.sun_dir = vec3(make_ecef_from_enu_rotation(camera) * dvec3(0.0, -std::cos(e), std::sin(e)));
    c.sun_angular_radius_rad = 0.00465f;
    c.sun_illuminance = vec3(127000.0f);
    c.sun_distance_factor = 1.0f;
    c.sun_illuminance_1au = c.key_illuminance = c.sun_illuminance;
    c.key_dir = c.sun_dir;
    c.light_count = 1;
    c.size = {v.size.width, v.size.height};
    c.near_m = 0.1f;
    frame.buffer = graph.constants("frame", c);
    return frame;
  }

  /// Renders; the surface is the ellipsoid, where the ray meets it.
  Picture render(const View& v, const CloudParams& params) {
    weather.update({.coverage = params.coverage, .contrast = params.weather_contrast, .seed = params.weather_seed});
    FrameGraph graph;
    const FrameInfo frame = frame_of(graph, v);
    std::vector<float> depth(size_t{v.size.width} * v.size.height);
    for (uint32_t y = 0, i = 0; y < v.size.height; ++y)
      for (uint32_t x = 0; x < v.size.width; ++x, ++i) {
        vec2_t t{};
        const vec3 dir =
            shared::pixel_direction(frame.constants, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
        depth[i] =
            shared::intersect_shell(frame.constants.planet, dir, 0.0f, t) && t.x > 0.0f ? t.x : shared::kFarDepth_m;
      }
    gpu::Image depth_image = device.create_image({.name = "depth", .extent = v.size, .format = Format::r32f});
    const gpu::ImageUpload upload{.image = &depth_image, .bytes = std::as_bytes(std::span(depth))};
    device.upload({&upload, 1});
    const CloudMarchPass::Inputs in{.depth_m = graph.import(depth_image),
                                    .atmosphere = atmosphere.add(graph, {}),
                                    .density = import_cloud_density(graph, frame, params, noise, weather)};
    const CloudMarchPass::Outputs out = march.add(graph, frame, params, in);
    graph.keep(out.radiance);
    graph.keep(out.info);
    executor.run(graph);
    return {executor.read<float>(out.radiance), executor.read<float>(out.info)};
  }
  using vec2_t = glm::vec2;

  std::vector<float> column_depths(double lat_deg, double lon_deg, const CloudParams& params, double footprint_m) {
    weather.update({.coverage = params.coverage, .contrast = params.weather_contrast, .seed = params.weather_seed});
    FrameGraph graph;
    const FrameInfo frame = frame_of(graph, {.lat_deg = lat_deg, .lon_deg = lon_deg, .height_m = 0.0});
    const dmat3 axes = make_ecef_from_enu_rotation(Geodetic::from_degrees(lat_deg, lon_deg));
    const ImageRef out =
        columns.add(graph, frame, import_cloud_density(graph, frame, params, noise, weather),
                    {.east = vec3(axes[0]), .north = vec3(axes[1]), .footprint_m = footprint_m, .count = 72});
    graph.keep(out);
    executor.run(graph);
    return executor.read<float>(out);
  }
};

CloudParams uniform_slab(double extinction_per_m) {
  CloudParams params;
  params.coverage = 1.0;
  params.uniform_density = 1.0;
  params.layers = {{.base_m = 1000.0, .thickness_m = 2000.0, .extinction_per_m = extinction_per_m}};
  return params;
}

const double kPlaces[4][2] = {{35.5, 138.7}, {-12.0, 30.0}, {62.0, -80.0}, {0.5, 179.9}};

TEST_CASE(
    "gpu: a uniform slab transmits exp(-extinction * path), seen from below, inside, above and space; misses are "
    "clear") {
  CloudFixture f;
  const auto centre = [&](double height_m, double pitch_deg, double extinction) {
    const View v{.height_m = height_m, .pitch_deg = pitch_deg, .fov_deg = 1.0, .size = {9, 9}};
    return f.render(v, uniform_slab(extinction)).at(4, 4, 9)[3];
  };
  // The shells are set apart for the ellipsoid by up to 0.34 %; a step at an edge counts whole or not at all: 1 / 160.
  const auto close = [](float t, double depth) { return std::abs(-std::log(t) - depth) < 0.008 * depth; };
  CHECK(close(centre(2.0, 90.0, 1e-3), 2.0));
  CHECK(close(centre(2000.0, 90.0, 1e-3), 1.0));
  CHECK(close(centre(2000.0, -90.0, 1e-3), 1.0));
  CHECK(close(centre(20e3, -90.0, 1e-3), 2.0));
  CHECK(close(centre(400e3, -90.0, 1e-3), 2.0));
  CHECK(close(centre(35786e3, -90.0, 1e-3), 2.0));
  CHECK(close(centre(2.0, 30.0, 5e-4), 2.0));
  CHECK(centre(20e3, 10.0, 1e-3) == 1.0f);
}

TEST_CASE("gpu: pictures are finite, transmittances within 0..1, and the same twice") {
  CloudFixture f;
  for (const View& v :
       {View{}, View{.height_m = 1900.0, .pitch_deg = 0.0}, View{.height_m = 4000.0, .pitch_deg = -8.0},
        View{.height_m = 400e3, .pitch_deg = -60.0}, View{.height_m = 35786e3, .pitch_deg = -90.0, .fov_deg = 18.0},
        View{.pitch_deg = 10.0, .sun_elevation_deg = -4.0}}) {
    const Picture a = f.render(v, {}), b = f.render(v, {});
    CHECK(a.radiance == b.radiance);
    CHECK(a.info == b.info);
    bool fine = true, cloudy = false;
    for (size_t i = 0; i < a.radiance.size(); i += 4) {
      for (size_t c = 0; c < 4; ++c)
        fine = fine && std::isfinite(a.radiance[i + c]) && std::isfinite(a.info[i + c]) && a.radiance[i + c] >= 0.0f;
      fine = fine && a.radiance[i + 3] <= 1.0f;
      cloudy = cloudy || a.radiance[i + 3] < 0.5f;
      if (a.radiance[i + 3] == 1.0f) fine = fine && a.info[i] == shared::kFarDepth_m && a.info[i + 2] == 0.0f;
    }
    CHECK(fine);
    CHECK(cloudy);
  }
}

TEST_CASE("gpu: no coverage is exactly clear") {
  CloudFixture f;
  CloudParams params;
  params.coverage = 0.0;
  const Picture p = f.render({}, params);
  for (size_t i = 0; i < p.radiance.size(); i += 4) {
    CHECK(p.radiance[i] == 0.0f);
    CHECK(p.radiance[i + 3] == 1.0f);
    CHECK(p.info[i] == shared::kFarDepth_m);
  }
  for (const float depth : f.column_depths(35.5, 138.7, params, 10.0)) CHECK(depth == 0.0f);
}

TEST_CASE("gpu: under uniform weather the share of sky with optical depth above 1 is the coverage within 0.05") {
  CloudFixture f;
  for (const double coverage : {0.1, 0.4, 0.7, 1.0}) {
    CloudParams params;
    params.coverage = coverage;
    params.weather_contrast = 0.0;
    double share = 0.0, fine_cover = 0.0, far_cover = 0.0, count = 0.0;
    for (const auto& place : kPlaces) {
      for (const float depth : f.column_depths(place[0], place[1], params, 10.0)) {
        share += depth > 1.0f;
        fine_cover += 1.0 - std::exp(-depth);
        count += 1.0;
      }
      for (const float depth : f.column_depths(place[0], place[1], params, 30e3)) far_cover += 1.0 - std::exp(-depth);
    }
    CAPTURE(coverage);
    CHECK(std::abs(share / count - coverage) < 0.05);
    CHECK(std::abs(far_cover - fine_cover) / count < 0.05);  // the field seen from space has the same mean opacity
  }
}

TEST_CASE(
    "gpu: sunlit tops are 0.6 to 1 times as luminous as a white surface that faces the sun, shaded parts not black") {
  CloudFixture f;
  const Picture p = f.render(
      {.height_m = 6000.0, .heading_deg = 0.0, .pitch_deg = -30.0, .sun_elevation_deg = 45.0, .size = {128, 72}}, {});
  std::vector<double> luminance;
  for (size_t i = 0; i < p.radiance.size(); i += 4)
    if (p.radiance[i + 3] < 0.01f)
      luminance.push_back(0.2126 * p.radiance[i] + 0.7152 * p.radiance[i + 1] + 0.0722 * p.radiance[i + 2]);
  REQUIRE(luminance.size() > 500);
  std::sort(luminance.begin(), luminance.end());
  const double white = 110e3 / M_PI;  // the sun at 3 km, 45 deg up, in lux
  CHECK(luminance[luminance.size() * 98 / 100] > 0.6 * white);
  CHECK(luminance[luminance.size() * 98 / 100] < 1.0 * white);
  CHECK(luminance[luminance.size() / 50] > 0.05 * white);
}

TEST_CASE("gpu: noise volumes wrap, have mean 0 and the stated variance") {
  CloudFixture f;
  const std::vector<std::byte> bytes = f.device.download(f.noise.shape());
  constexpr size_t n = 128;
  const auto value = [&](size_t x, size_t y, size_t z) {
    return (static_cast<double>(bytes[(z * n + y) * n + x]) / 255.0 - 0.5) * 8.0;
  };
  double mean = 0.0, square = 0.0, wrap = 0.0, inner = 0.0;
  for (size_t z = 0; z < n; ++z)
    for (size_t y = 0; y < n; ++y) {
      for (size_t x = 0; x < n; ++x) mean += value(x, y, z), square += std::pow(value(x, y, z), 2);
      wrap += std::pow(value(0, y, z) - value(n - 1, y, z), 2) + std::pow(value(y, z, 0) - value(y, z, n - 1), 2);
      inner += std::pow(value(40, y, z) - value(41, y, z), 2) + std::pow(value(y, z, 90) - value(y, z, 91), 2);
    }
  CHECK(std::abs(mean / (n * n * n)) < 0.02);
  CHECK(std::abs(square / (n * n * n) - 1.0) < 0.05);
  CHECK(wrap / inner == doctest::Approx(1.0).epsilon(0.25));
  CHECK(f.noise.variance()[0].x == doctest::Approx(1.0).epsilon(0.01));
  for (size_t mip = 0; mip < 9; ++mip)
    for (int c = 0; c < 4; ++c)
      CHECK(
          std::abs(shared::variance_left(static_cast<float>(mip), f.noise.fade_start()[c], f.noise.fade_per_lod()[c]) -
                   f.noise.variance()[mip][c]) < 0.08);
}

TEST_CASE(
    "gpu: noise coordinates of one place are the same through cameras 10 km and half a world apart; wind moves them") {
  CloudFixture f;
  FrameGraph graph;
  const dvec3 place = ecef_from_geodetic(Geodetic::from_degrees(35.5, 138.7, 2000.0));
  const auto coordinate = [&](const View& v, double time_s, const CloudParams& params, uint32_t domain) {
    const FrameInfo frame = f.frame_of(graph, v, time_s);
    const shared::CloudDomain d = make_cloud_constants(frame, params, f.noise, f.weather).domains[domain];
    return dvec3(d.offset) + glm::dmat3(d.uvw_from_cam) * (place - frame.camera_ecef_m);
  };
  for (uint32_t domain = 0; domain < shared::kCloudDomains; ++domain) {
    const dvec3 here = coordinate({}, 0.0, {}, domain);
    const dvec3 near = coordinate({.lat_deg = 35.59}, 0.0, {}, domain);
    const dvec3 d = here - near - glm::round(here - near);
    CHECK(glm::length(d) < 1e-4);  // float rotation over 10 km against a period of 137 m and more
  }
  CloudParams windy;
  windy.wind_east_mps = 10.0;
  CHECK(coordinate({}, 1000.0, windy, 2) == coordinate({}, 1000.0, windy, 2));
  CHECK(glm::length(coordinate({}, 1000.0, windy, 2) - coordinate({}, 0.0, windy, 2)) > 0.01);
}

}  // namespace
}  // namespace nepho
