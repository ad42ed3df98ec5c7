// Light shafts against brute force: the same field, marched towards the sun from every one of 512 points of a ray.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <map>

#include "astro/sky_bodies.h"
#include "atmosphere/atmosphere_tables.h"
#include "atmosphere/luminance.h"
#include "clouds/cloud_density.h"
#include "clouds/shadow_map.h"
#include "gpu/commands.h"
#include "render/frame_setup.h"
#include "render/reference_scene.h"
#include "render/shaft_test.comp.h"

using namespace nepho;
using namespace nepho::test;

namespace {

constexpr uint32_t kSteps = 512;
constexpr float kSunStep_m = 25.0f;

struct View {
  const char* name;
  const char* genus;
  double coverage;
  const char* time;
  double height_m, heading_deg, pitch_deg, fov_deg;
};

/// Broken cumulus at a low sun, seen from the ground and from above; an overcast with gaps.
const View kViews[] = {
    {"broken cumulus, sun at 11 degrees", "cumulus", 0.25, "2026-06-20T20:36:00Z", 100.0, 60.0, 8.0, 60.0},
    {"overcast with gaps, sun at 58 degrees", "stratocumulus", 0.7, "2026-06-21T00:30:00Z", 100.0, 75.0, 12.0, 70.0},
    {"from above, sun at 17 degrees", "cumulus", 0.4, "2026-06-20T21:06:00Z", 6000.0, 60.0, -20.0, 60.0},
};

Scene scene_of(const View& view, const std::string& method, Extent2D size) {
  Scene scene = reference_scene(half_sky(view.genus, view.coverage), size);
  scene.time = view.time;
  scene.camera.height_m = view.height_m;
  scene.camera.heading_deg = view.heading_deg;
  scene.camera.pitch_deg = view.pitch_deg;
  scene.camera.fov_deg = view.fov_deg;
  scene.imagery.bare_albedo = 0.2;
  scene.night_sky.moon = false;
  scene.clouds.multiple_scattering = "octaves";  // what clouds look like does not matter
  scene.render.quality = "high";
  scene.render.frames = 1;
  scene.shafts.method = method;
  scene.shafts.screen_glow = 0.0;  // besides the shafts
  return scene;
}

struct Drawn {
  ImageBuffer layers;
  CameraPose pose;
  std::vector<gpu::PassTiming> passes;
};

Drawn draw(gpu::Device& device, const Scene& scene, uint32_t frame_number = 0) {
  Renderer renderer(device, {}, scene);
  RenderRequest request;
  request.frame_number = frame_number;
  request.display = false;
  RenderResult result = renderer.render(request);
  return {std::move(result.layers), result.pose, renderer.timings().passes};
}

struct Stretch {
  glm::vec3 dir;
  float from_m, to_m;
};
struct Step {
  glm::vec3 single;
  float visible, by_map, cloud_per_m;
};
double luminance(const glm::vec3& c) {
  return 0.2126 * static_cast<double>(c.x) + 0.7152 * static_cast<double>(c.y) + 0.0722 * static_cast<double>(c.z);
}

/// The truth for some pixels of a picture.
class BruteForce {
 public:
  BruteForce(GpuFixture& gpu, const Scene& scene, const CameraPose& pose)
      : gpu_(gpu),
        clouds_(gpu.device, scene.clouds),
        maps_(gpu.device, clouds_, {}),
        atmosphere_(gpu.device, scene.atmosphere),
        constants_(clouds_.specialisation(2)),
        pipeline_(gpu.device, {.name = "shaft_test", .spirv = shaft_test_comp, .constants = specialise()}) {
    const UtcInstant utc = parse_utc(scene.time);
    time_s_ = utc.seconds_since_2000();
    const FrameLight light =
        FrameLight::from(sky_bodies_at(utc), sun_illuminance_at_1au(scene.atmosphere), scene.night_sky.moon);
    frame_.camera_ecef_m = pose.ecef_m;
    frame_.time_s = time_s_;
    frame_.extent = {scene.render.width, scene.render.height};
    frame_.constants = make_frame_constants(pose, frame_.extent, light, time_s_, 0, 0, glm::vec2(0.0f));
  }
  const shared::FrameConstants& frame() const { return frame_.constants; }
  float top_m() const { return clouds_.constants().hull_high_m * 1.0034f + 1.0f; }

  std::vector<Step> steps(const std::vector<Stretch>& rays) {
    std::vector<Step> all;
    const uint32_t batch = 8;
    for (size_t first = 0; first < rays.size(); first += batch) {
      const std::vector<Stretch> some(rays.begin() + static_cast<long>(first),
                                      rays.begin() + static_cast<long>(std::min(first + batch, rays.size())));
      FrameGraph graph;
      FrameInfo frame = frame_;
      frame.buffer = graph.constants("frame", frame.constants);
      const CloudDensityRefs density = import_cloud_density(graph, frame, clouds_);
      const CloudShadowRefs shadow = maps_.add(graph, frame, density);
      const BufferRef out = graph.create_buffer("steps", some.size() * kSteps * sizeof(Step));
      auto pass = graph.pass("shaft_test");
      pass.uniform("frame", frame.buffer).read("stretches", graph.constants("stretches", some)).write("steps", out);
      bind_density(pass, density);
      bind_cloud_shadow(pass, shadow);
      AtmosphereTables::bind(pass, atmosphere_.add(graph, {}));
      struct Push {
        uint32_t first, count, steps;
        float step_m, low_m, high_m;
      } push{0,          static_cast<uint32_t>(some.size()) * kSteps, kSteps,
             kSunStep_m, clouds_.constants().hull_low_m - 1.0f,       clouds_.constants().hull_high_m + 1.0f};
      pass.record([this, push](gpu::Commands& cmd) { cmd.bind(pipeline_).push(push).dispatch_threads(push.count); });
      graph.keep(out);
      gpu_.executor.run(graph);
      const std::vector<Step> got = gpu_.executor.read<Step>(out);
      all.insert(all.end(), got.begin(), got.end());
    }
    return all;
  }

 private:
  std::vector<uint32_t> specialise() {
    constants_[0] = atmosphere_.spectral_groups();
    return constants_;
  }
  GpuFixture& gpu_;
  Clouds clouds_;
  CloudShadowMaps maps_;
  AtmosphereTables atmosphere_;
  std::vector<uint32_t> constants_;
  gpu::ComputePipeline pipeline_;
  FrameInfo frame_;
  double time_s_ = 0.0;
};

/// One pixel's truth.
struct Truth {
  size_t pixel;
  double single;  ///< luminance of the air's single scattering as the eye sees it, without shade
  double drawn;   ///< the same before the clouds of the picture, which may stand a few metres off
  double lost;    ///< of single, in shade
  double by_map;  ///< the same with the shade of the shadow maps
};

/// Every pixel of a regular grid of the picture.
std::vector<Truth> truth_of(BruteForce& brute, const Drawn& drawn, uint32_t every) {
  const uint32_t width = drawn.layers.width, height = drawn.layers.height;
  const std::vector<float>&depth = channel(drawn.layers, "depth.Z"),
        &clear = channel(drawn.layers, "cloud.transmittance"), &cloud_m = channel(drawn.layers, "cloud.depth_m");
  std::vector<Truth> truth;
  std::vector<Stretch> rays;
  for (uint32_t y = every / 2; y < height; y += every)
    for (uint32_t x = every / 2; x < width; x += every) {
      const size_t k = size_t{y} * width + x;
      const glm::vec3 dir = shared::pixel_direction(brute.frame(), glm::vec2(x, y) + 0.5f);
      glm::vec2 t(0.0f);
      if (!shared::intersect_shell(brute.frame().planet, dir, brute.top_m(), t) || t.y <= 0.0f) continue;
      const float from = std::max(t.x, 0.0f), to = std::min(t.y, depth[k]);
      if (to <= from) continue;
      truth.push_back({k, 0.0, 0.0, 0.0, 0.0});
      rays.push_back({dir, from, to});
    }
  const std::vector<Step> steps = brute.steps(rays);
  for (size_t r = 0; r < rays.size(); ++r) {
    // Air counts as much as the clouds before it let through. What these hide in all is what the picture says; where
    // the ray misses them (the picture's are as wide as its pixel), so is how far they are.
    const double a = static_cast<double>(clear[truth[r].pixel]), at_m = static_cast<double>(cloud_m[truth[r].pixel]);
    const double step_m = static_cast<double>(rays[r].to_m - rays[r].from_m) / kSteps;
    const auto depth_of = [&](uint32_t i) { return static_cast<double>(steps[r * kSteps + i].cloud_per_m) * step_m; };
    const auto start_of = [&](uint32_t i) { return static_cast<double>(rays[r].from_m) + step_m * i; };
    const auto before = [&](double distance_m, uint32_t i) {
      return std::clamp((distance_m - start_of(i)) / step_m, 0.0, 1.0);
    };
    double whole = 0.0, mean_m = 0.0;
    for (uint32_t i = 0; i < kSteps; ++i) {
      mean_m += std::exp(-whole) * -std::expm1(-depth_of(i)) * (start_of(i) + 0.5 * step_m);
      whole += depth_of(i);
    }
    const bool meets = whole > 1e-3;
    mean_m = meets ? mean_m / -std::expm1(-whole) : at_m;
    double optical_depth = 0.0;
    for (uint32_t i = 0; i < kSteps; ++i) {
      const Step& step = steps[r * kSteps + i];
      const double here = std::max(depth_of(i), 1e-9);
      const double seen = std::exp(-optical_depth) * -std::expm1(-here) / here;
      optical_depth += here;
      const double open = meets ? 1.0 - (1.0 - seen) / -std::expm1(-whole) : before(at_m, i);
      const double light = luminance(step.single) * (a + (1.0 - a) * open);
      truth[r].single += light;
      truth[r].drawn += light + luminance(step.single) * (1.0 - a) * (before(at_m, i) - before(mean_m, i));
      truth[r].lost += light * (1.0 - static_cast<double>(step.visible));
      truth[r].by_map += light * (1.0 - static_cast<double>(step.by_map));
    }
  }
  return truth;
}

struct Errors {
  double error, bias, lost_error, map_error;
  size_t pixels;
};

/// Over pixels that lose 2 % or more: sum |L - L_true| / sum L_true of the shaded single scattering, L being the
/// unshaded one that the picture holds (the true one before its clouds) plus the change of the picture; signed; the
/// same per what is lost; and what the shadow maps alone err by, marched as finely as the truth.
Errors errors_of(const std::vector<Truth>& truth, const ImageBuffer& without, const ImageBuffer& with) {
  const auto at = [](const ImageBuffer& image, size_t k) {
    return luminance({channel(image, "R")[k], channel(image, "G")[k], channel(image, "B")[k]});
  };
  double sum = 0.0, off = 0.0, bias = 0.0, lost = 0.0, map = 0.0;
  size_t pixels = 0;
  for (const Truth& t : truth) {
    if (t.lost < 0.02 * t.single) continue;
    const double change = at(with, t.pixel) - at(without, t.pixel);
    sum += t.single - t.lost;
    lost += t.lost;
    const double error = (t.drawn + change) - (t.single - t.lost);
    off += std::abs(error);
    bias += error;
    map += std::abs(t.by_map - t.lost);
    ++pixels;
  }
  return {off / sum, bias / sum, off / lost, map / sum, pixels};
}

}  // namespace

TEST_CASE("gpu: shafts are within 10 % (shadow-length) and 15 % (froxel) of brute-force single scattering") {
  GpuFixture gpu;
  const Extent2D size{128, 72};
  const uint32_t every = full_size() ? 3 : 8;
  const std::map<std::string, double> allowed = {{"shadow-length", 0.10}, {"froxel", 0.15}, {"screen", 1e9}};
  for (const View& view : kViews) {
    const Drawn without = draw(gpu.device, scene_of(view, "none", size));
    BruteForce brute(gpu, scene_of(view, "none", size), without.pose);
    const std::vector<Truth> truth = truth_of(brute, without, every);
    double single = 0.0, lost = 0.0;
    for (const Truth& t : truth) single += t.single, lost += t.lost;
    REQUIRE(lost > 0.05 * single);  // there is shade
    const Errors none = errors_of(truth, without.layers, without.layers);
    for (const auto& [method, most] : allowed) {
      const Drawn with = draw(gpu.device, scene_of(view, method, size));
      const Errors e = errors_of(truth, without.layers, with.layers);
      double ms = 0.0;
      for (const gpu::PassTiming& pass : with.passes)
        if (pass.name.starts_with("shafts.") || pass.name.starts_with("froxel")) ms += pass.gpu_ms;
      std::printf(
          "shafts | %s | %s | error %.1f %% bias %+.1f %% (maps alone %.1f %%, no shafts %.0f %%) | per lost light "
          "%.1f %% "
          "| "
          "lost %.0f %% | %zu pixels | %.0f ms\n",
          view.name, method.c_str(), 100.0 * e.error, 100.0 * e.bias, 100.0 * e.map_error, 100.0 * none.error,
          100.0 * e.lost_error, 100.0 * lost / single, e.pixels, ms);
      CHECK_MESSAGE(e.error <= most, view.name, ", ", method);
      CHECK_MESSAGE(e.error <= 1.001 * none.error, view.name, ", ", method);  // screen knows no distances
    }
  }
}

TEST_CASE("gpu: blocks of 2 x 2 pixels lose the light that a ray for every pixel loses") {
  GpuFixture gpu;
  View view = kViews[0];
  view.fov_deg = 15.0;  // pixels of 0.2 degrees: wider ones have rays of their own
  const Extent2D size{128, 72};
  const auto lights = [&](const std::string& method, uint32_t downscale) {
    Scene scene = scene_of(view, method, size);
    scene.shafts.downscale = downscale;
    const ImageBuffer layers = draw(gpu.device, scene).layers;
    std::vector<double> y;
    for (size_t k = 0; k < size_t{size.width} * size.height; ++k)
      y.push_back(luminance({channel(layers, "R")[k], channel(layers, "G")[k], channel(layers, "B")[k]}));
    return y;
  };
  const std::vector<double> clear = lights("none", 1), own = lights("shadow-length", 1),
                            shared = lights("shadow-length", 2);
  double lost = 0.0, off = 0.0, bias = 0.0;
  for (size_t k = 0; k < clear.size(); ++k) {
    lost += clear[k] - own[k];
    off += std::abs(shared[k] - own[k]);
    bias += shared[k] - own[k];
  }
  std::printf("shafts | blocks of 2 x 2 | error %.2f %% of what is lost, bias %+.2f %%\n", 100.0 * off / lost,
              100.0 * bias / lost);
  CHECK(off > 0.0);  // there are blocks
  CHECK(off < 0.03 * lost);
  CHECK(std::abs(bias) < 0.01 * lost);
}

TEST_CASE("gpu: pictures of a sequence lose the light that a still one loses") {
  GpuFixture gpu;
  View view = kViews[0];
  view.fov_deg = 25.0;
  const Extent2D size{160, 90};
  // What shade takes, per pixel.
  const auto lost = [&](uint32_t frame_number) {
    std::vector<double> y(size_t{size.width} * size.height, 0.0);
    for (const char* method : {"none", "shadow-length"}) {
      const ImageBuffer layers = draw(gpu.device, scene_of(view, method, size), frame_number).layers;
      const double sign = std::string(method) == "none" ? 1.0 : -1.0;
      for (size_t k = 0; k < y.size(); ++k)
        y[k] += sign * luminance({channel(layers, "R")[k], channel(layers, "G")[k], channel(layers, "B")[k]});
    }
    return y;
  };
  const std::vector<double> still = lost(0), one_of_many = lost(1);
  double whole = 0.0, off = 0.0, bias = 0.0;
  for (size_t k = 0; k < still.size(); ++k) {
    whole += still[k];
    off += std::abs(one_of_many[k] - still[k]);
    bias += one_of_many[k] - still[k];
  }
  std::printf("shafts | of a sequence | off by %.2f %% of what is lost, bias %+.2f %%\n", 100.0 * off / whole,
              100.0 * bias / whole);
  CHECK(off < 0.1 * whole);
  CHECK(std::abs(bias) < 0.03 * whole);
}
