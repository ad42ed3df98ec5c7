#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/vec4.hpp>

#include "clouds/cloud_march_pass.h"
#include "clouds/cloud_probe.h"
#include "clouds/droplet_phase.h"
#include "clouds/statistics.h"
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
  CloudFixture() : atmosphere(device, air()) {}
  static AtmosphereParams air() {
    AtmosphereParams params;
    params.spectral = "fast";  // quicker to compute; nothing here depends on colours
    params.scattering_orders = 2;
    return params;
  }
  AtmosphereTables atmosphere;
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
  /// Without `lit` light that was scattered more than once is left out: it does not touch transmittances.
  Picture render(const View& v, const Clouds& clouds, const CloudMarchPass& march, bool lit = false) {
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
    CloudLight light(device, clouds, atmosphere.spectral_groups(), CloudLight::quality_of("medium"));
    if (!lit) {
      CloudParams unlit = clouds.params();
      unlit.multiple_scattering = "octaves";
      light.renew(unlit);
    }
    CloudMarchPass::Inputs in{.depth_m = graph.import(depth_image),
                              .atmosphere = atmosphere.add(graph, {}),
                              .density = import_cloud_density(graph, frame, clouds),
                              .light = {}};
    in.light = light.add(graph, frame, {.depth_m = in.depth_m, .density = in.density});
    const CloudMarchPass::Outputs out = march.add(graph, frame, in);
    graph.keep(out.radiance);
    graph.keep(out.info);
    executor.run(graph);
    return {executor.read<float>(out.radiance), executor.read<float>(out.info)};
  }
  /// What the march alone gives in the mean of a picture straight down: shares of sun, sky and ground, transmittance.
  glm::vec4 marched(const View& v, const CloudParams& params) {
    const Clouds clouds(device, params);
    const CloudMarchPass march(device, clouds, atmosphere.spectral_groups());
    FrameGraph graph;
    const FrameInfo frame = frame_of(graph, v);
    const std::vector<float> depth(size_t{v.size.width} * v.size.height, static_cast<float>(v.height_m));
    gpu::Image depth_image = device.create_image({.name = "depth", .extent = v.size, .format = Format::r32f});
    const gpu::ImageUpload upload{.image = &depth_image, .bytes = std::as_bytes(std::span(depth))};
    device.upload({&upload, 1});
    CloudLight light(device, clouds, atmosphere.spectral_groups(), CloudLight::quality_of("medium"));
    const ImageRef depth_m = graph.import(depth_image);
    const CloudDensityRefs density = import_cloud_density(graph, frame, clouds);
    const CloudLight::Refs lit = light.add(graph, frame, {.depth_m = depth_m, .density = density});
    const auto out = march.add_march(graph, frame, {.depth_m = depth_m, .density = density, .light = lit});
    graph.keep(out.light);
    executor.run(graph);
    const std::vector<float> shares = executor.read<float>(out.light);
    glm::vec4 mean(0.0f);
    for (size_t i = 0; i < shares.size(); i += 4)
      mean += glm::vec4(shares[i], shares[i + 1], shares[i + 2], shares[i + 3]);
    return mean / static_cast<float>(shares.size() / 4);
  }
  Picture render(const View& v, const CloudParams& params, bool lit = false) {
    const Clouds clouds(device, params);
    return render(v, clouds, CloudMarchPass(device, clouds, atmosphere.spectral_groups()), lit);
  }
  using vec2_t = glm::vec2;
};

CloudParams uniform_slab(double extinction_per_m) {
  CloudParams params;
  params.coverage = 1.0;
  params.uniform_density = 1.0;
  params.scattering_per_m = extinction_per_m;
  params.layers = {{.base_m = 1000.0, .thickness_m = 2000.0}};
  return params;
}

/// Emergent radiance by octave_sum() of a slab of albedo 1 under a sun of illuminance 1, seen vertically from above.
double octaves_from_above(const CloudParams& params, double tau, double mu0) {
  double sum = 0.0;
  for (double f = 1.0; f > 1.0 / 200.0; f *= 0.5) {
    const double k = 1.0 + f / mu0;
    const float phase = shared::phase_lobes(
        shared::phase_wider(droplet_phase(params).constants(), static_cast<float>(f)), static_cast<float>(-mu0));
    sum += f * static_cast<double>(phase) * (1.0 - std::exp(-tau * k)) / k;
  }
  return sum;
}

/// Cumulus above the ellipsoid with the same weather everywhere.
CloudParams cumulus(double coverage) {
  CloudParams params;
  params.coverage = coverage;
  return params;
}

/// Columns over a square of 300 km around a place, 6.25 km apart.
std::vector<CloudProbe::Case> square(double lat_deg, double lon_deg, double footprint_m) {
  constexpr int kSide = 48;
  const dmat4 ecef_from_enu = make_ecef_from_enu(Geodetic::from_degrees(lat_deg, lon_deg));
  std::vector<CloudProbe::Case> cases;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const double east = (x + 0.5 - kSide / 2) * 300e3 / kSide, north = (y + 0.5 - kSide / 2) * 300e3 / kSide;
      Geodetic at = geodetic_from_ecef(dvec3(ecef_from_enu * glm::dvec4(east, north, 0.0, 1.0)));
      at.height_m = 0.0;
      cases.push_back({.point = at, .camera = {}, .time_s = 0.0, .footprint_m = footprint_m});
    }
  return cases;
}

TEST_CASE("gpu: with octaves a slab sends the octave sum integrated over depth; the transmittance stays") {
  CloudFixture f;
  for (const double tau : {0.5, 4.0, 20.0}) {
    CAPTURE(tau);
    CloudParams params = uniform_slab(tau / 1000.0);
    params.layers[0].thickness_m = 1000.0;
    const View v{.height_m = 5e3, .pitch_deg = -90.0, .fov_deg = 1.0, .sun_elevation_deg = 60.0, .size = {8, 8}};
    const glm::vec4 cells = f.marched(v, params);
    params.multiple_scattering = "octaves";
    const glm::vec4 octaves = f.marched(v, params);
    // Four looks at the sun a ray stand for all depths: 6.5 % off at the deepest.
    CAPTURE(octaves.x);
    const double expected = octaves_from_above(params, tau, std::sin(rad_from_deg(60.0)));
    CHECK(std::abs(static_cast<double>(octaves.x) / expected - 1.0) < 0.07);
    CHECK(std::abs(octaves.x / cells.x - 1.0f) > 0.1f);
    CHECK(octaves.w == cells.w);
  }
}

TEST_CASE("gpu: without light scattered more than once a slab sends single scattering, for all phase functions") {
  CloudFixture f;
  const double tau = 1.0, mu0 = std::sin(rad_from_deg(60.0));
  const View v{.height_m = 5e3, .pitch_deg = -90.0, .fov_deg = 1.0, .sun_elevation_deg = 60.0, .size = {8, 8}};
  for (const char* phase : {"dual_hg", "cornette_shanks", "mie"})
    for (const char* method : {"octaves", "cells"}) {
      CAPTURE(phase);
      CAPTURE(method);
      CloudParams params = uniform_slab(tau / 1000.0);
      params.layers[0].thickness_m = 1000.0;
      params.multiple_scattering = method;
      params.multiple_scattering_weight = 0.0;
      params.phase = phase;
      // Seen from straight above; light turns by the angle whose cosine is -mu0.
      const double k = 1.0 + 1.0 / mu0, expected = droplet_phase(params)(-mu0) * (1.0 - std::exp(-tau * k)) / k;
      const glm::vec4 single = f.marched(v, params);
      CHECK(static_cast<double>(single.x) == doctest::Approx(expected).epsilon(0.02));
      params.multiple_scattering_weight = 0.5;
      const glm::vec4 half = f.marched(v, params);
      params.multiple_scattering_weight = 1.0;
      const glm::vec4 all = f.marched(v, params);
      CHECK(half.x == doctest::Approx(0.5f * (single.x + all.x)).epsilon(1e-3));
      CHECK(all.x > 1.3f * single.x);
      CHECK(half.y == all.y);  // the sky's light stays
    }
}

TEST_CASE("gpu: powder takes light from thin edges and is Schneider's formula on a slab") {
  CloudFixture f;
  const double tau = 1.0, mu0 = std::sin(rad_from_deg(60.0));
  const View v{.height_m = 5e3, .pitch_deg = -90.0, .fov_deg = 1.0, .sun_elevation_deg = 60.0, .size = {8, 8}};
  CloudParams params = uniform_slab(tau / 1000.0);
  params.layers[0].thickness_m = 1000.0;
  params.multiple_scattering_weight = 0.0;
  for (const double powder : {0.5, 1.0}) {
    CAPTURE(powder);
    params.powder = powder;
    // exp(-d) (1 + s (1 - 2 exp(-2 d))) over depth, d towards the sun, s as seen at this angle.
    const double s = powder * 0.5 * (1.0 + mu0), k = 1.0 + 1.0 / mu0, k3 = 1.0 + 3.0 / mu0;
    const double expected = droplet_phase(params)(-mu0) *
                            ((1.0 + s) * (1.0 - std::exp(-tau * k)) / k - 2.0 * s * (1.0 - std::exp(-tau * k3)) / k3);
    // Few looks at the sun stand for all depths.
    CHECK(static_cast<double>(f.marched(v, params).x) == doctest::Approx(expected).epsilon(0.05));
  }
  // Darker where the slab is thin, up to twice as bright where it is not; light that was traced stays.
  params.multiple_scattering_weight = 1.0;
  const auto change = [&](double depth) {
    params.scattering_per_m = depth / 1000.0;
    params.powder = 0.0;
    const float plain = f.marched(v, params).x;
    params.powder = 1.0;
    return f.marched(v, params).x / plain;
  };
  CHECK(change(0.1) < 0.4f);
  const float deep = change(8.0);
  CHECK(deep > 1.0f);
  CHECK(deep < 2.0f);
}

TEST_CASE(
    "gpu: a uniform slab transmits exp(-extinction * path), seen from below, inside, above and space; misses are "
    "clear") {
  CloudFixture f;
  const Clouds dense(f.device, uniform_slab(1e-3)), thin(f.device, uniform_slab(5e-4));
  const CloudMarchPass march_dense(f.device, dense, f.atmosphere.spectral_groups()),
      march_thin(f.device, thin, f.atmosphere.spectral_groups());
  const auto centre = [&](double height_m, double pitch_deg, double extinction) {
    const View v{.height_m = height_m, .pitch_deg = pitch_deg, .fov_deg = 1.0, .size = {9, 9}};
    return (extinction == 1e-3 ? f.render(v, dense, march_dense) : f.render(v, thin, march_thin)).at(4, 4, 9)[3];
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

TEST_CASE("gpu: layers far apart in height add up, seen from below, above and between, and the gap costs no samples") {
  CloudFixture f;
  // Even decks: full cover, no relief, no carving, the same density all through.
  CloudParams params;
  params.coverage = 1.0;
  const CloudLayer low{.base_m = 1000.0,
                       .thickness_m = 500.0,
                       .density_scale = 0.05,
                       .density_profile = {.linear_term = 0.0, .constant_term = 1.0},
                       .shape_amount = 0.0,
                       .detail_amount = 0.0,
                       .top_relief = 0.0,
                       .cover_optical_depth = 0.1};
  CloudLayer high = low;
  high.base_m = 9000.0;
  high.density_scale = 0.02;
  struct Deck {
    Clouds clouds;
    CloudMarchPass march;
    Deck(CloudFixture& f, const CloudParams& params)
        : clouds(f.device, params), march(f.device, clouds, f.atmosphere.spectral_groups()) {}
  };
  params.layers = {low};
  const Deck only_low(f, params);
  params.layers = {high};
  const Deck only_high(f, params);
  params.layers = {low, high};
  const Deck two(f, params);
  const auto march = [&](const Deck& deck, double height_m, double pitch_deg) {
    const View v{.height_m = height_m, .pitch_deg = pitch_deg, .fov_deg = 1.0, .size = {9, 9}};
    const Picture p = f.render(v, deck.clouds, deck.march);
    return std::array<double, 2>{-std::log(static_cast<double>(p.at(4, 4, 9)[3])),
                                 static_cast<double>(p.info[4 * 40 + 3])};
  };
  for (const double pitch : {90.0, -90.0}) {
    const double height = pitch > 0.0 ? 2.0 : 20e3;
    const auto a = march(only_low, height, pitch), b = march(only_high, height, pitch),
               both = march(two, height, pitch);
    CHECK(a[0] == doctest::Approx(0.05 * 0.04 * 500.0).epsilon(0.15));
    CHECK(b[0] == doctest::Approx(0.02 * 0.04 * 500.0).epsilon(0.15));
    CHECK(both[0] == doctest::Approx(a[0] + b[0]).epsilon(0.02));
    // info.w: steps + 1024 x samples.
    const double samples = std::floor(both[1] / 1024.0);
    const double apart = std::floor(a[1] / 1024.0) + std::floor(b[1] / 1024.0);
    CHECK(samples <= apart + 4.0);
  }
  CHECK(march(two, 5000.0, 90.0)[0] == doctest::Approx(march(only_high, 5000.0, 90.0)[0]).epsilon(0.02));
  CHECK(march(two, 5000.0, -90.0)[0] == doctest::Approx(march(only_low, 5000.0, -90.0)[0]).epsilon(0.02));
}

TEST_CASE("gpu: pictures from 400 km and from 4000 km of the same ground have the same transmittance") {
  CloudFixture f;
  for (const std::string genus : {"cumulus", "cirrus"}) {
    CAPTURE(genus);
    CloudParams params;
    params.coverage = 0.5;
    params.layers = {cloud_genus(genus).value()};
    params.layers[0].base_reference = "ellipsoid";
    const Clouds clouds(f.device, params);
    const CloudMarchPass march(f.device, clouds, f.atmosphere.spectral_groups());
    // 60 km of the layer's middle: pixels of 625 m from both heights, the lower picture averaged from 16 times as many.
    const uint32_t side = 96;
    const double middle_m = params.layers[0].base_m + 0.4 * params.layers[0].thickness_m;
    const auto picture = [&](double height_m, uint32_t pixels) {
      const View v{.lat_deg = -12.0,
                   .lon_deg = 30.0,
                   .height_m = height_m,
                   .heading_deg = 0.0,
                   .pitch_deg = -90.0,
                   .fov_deg = 2.0 * deg_from_rad(std::atan(30e3 / (height_m - middle_m))),
                   .size = {pixels, pixels}};
      return f.render(v, clouds, march);
    };
    const Picture near = picture(400e3, 4 * side), far = picture(4000e3, side);
    std::vector<double> a, b;
    // A margin: rays from 400 km lean by 4 degrees at the rim, where parallax shifts tops.
    for (uint32_t y = 8; y < side - 8; ++y)
      for (uint32_t x = 8; x < side - 8; ++x) {
        double mean_of_box = 0.0;
        for (uint32_t i = 0; i < 16; ++i)
          mean_of_box += static_cast<double>(near.at(4 * x + i % 4, 4 * y + i / 4, 4 * side)[3]) / 16.0;
        a.push_back(mean_of_box);
        b.push_back(static_cast<double>(far.at(x, y, side)[3]));
      }
    // The truth: columns at the pixels of the higher picture, inside the same margin.
    const dmat4 ecef_from_enu = make_ecef_from_enu(Geodetic::from_degrees(-12.0, 30.0));
    std::vector<CloudProbe::Case> columns;
    for (uint32_t y = 8; y < side - 8; ++y)
      for (uint32_t x = 8; x < side - 8; ++x) {
        const double east = (x + 0.5 - 0.5 * side) * 60e3 / side, north = (0.5 * side - y - 0.5) * 60e3 / side;
        Geodetic at = geodetic_from_ecef(dvec3(ecef_from_enu * glm::dvec4(east, north, 0.0, 1.0)));
        at.height_m = 0.0;
        columns.push_back({.point = at, .camera = {}, .time_s = 0.0, .footprint_m = 156.0});
      }
    CloudProbe probe(f.device, clouds);
    std::vector<double> truth;
    for (const CloudProbe::Column& c : probe.column(columns))
      truth.push_back(1.0 - std::exp(-static_cast<double>(c.optical_depth.x)));
    std::vector<double> opacity;
    for (const double t : b) opacity.push_back(1.0 - t);
    MESSAGE(genus, ": mean opacity of columns ", test::mean(truth), ", correlation with 4,000 km ",
            test::correlation(truth, opacity));
    const double alike = test::correlation(a, b), ratio = (1.0 - test::mean(b)) / (1.0 - test::mean(a));
    MESSAGE(genus, ": correlation ", alike, ", mean opacity from 400 km ", 1.0 - test::mean(a), ", from 4,000 km ",
            1.0 - test::mean(b));
    CHECK(alike >= 0.97);
    CHECK(std::abs(ratio - 1.0) < 0.05);
    CHECK(std::abs(test::mean(opacity) - test::mean(truth)) < 0.05);
  }
}

TEST_CASE("gpu: pictures are finite, transmittances within 0..1, and the same twice") {
  CloudFixture f;
  const Clouds clouds(f.device, cloud_sky("earth").value());
  const CloudMarchPass march(f.device, clouds, f.atmosphere.spectral_groups());
  for (const View& v :
       {View{}, View{.height_m = 1900.0, .pitch_deg = 0.0}, View{.height_m = 4000.0, .pitch_deg = -8.0},
        View{.height_m = 400e3, .pitch_deg = -60.0}, View{.height_m = 35786e3, .pitch_deg = -90.0, .fov_deg = 18.0},
        View{.pitch_deg = 10.0, .sun_elevation_deg = -4.0}}) {
    const bool lit = v.height_m == 4000.0;  // light in cells takes its time
    const Picture a = f.render(v, clouds, march, lit), b = f.render(v, clouds, march, lit);
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
  const Clouds clouds(f.device, params);
  for (const CloudProbe::Column& c : CloudProbe(f.device, clouds).column(square(35.5, 138.7, 10.0)))
    CHECK(c.optical_depth == glm::vec4(0.0f));
}

TEST_CASE(
    "gpu: sunlit tops are 0.6 to 1 times as luminous as a white surface that faces the sun, shaded parts not black") {
  CloudFixture f;
  const Picture p = f.render(
      {.height_m = 6000.0, .heading_deg = 0.0, .pitch_deg = -30.0, .sun_elevation_deg = 45.0, .size = {128, 72}},
      cumulus(0.4), true);
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

}  // namespace
}  // namespace nepho
