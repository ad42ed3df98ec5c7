// The air before clouds, where thin cloud is before far cloud. Clouds that only absorb have no light but that of the
// air before them, and the path tracer gives each collision its own air: brute force.
#include <cmath>

#include "astro/utc_time.h"
#include "atmosphere/atmosphere_tables.h"
#include "atmosphere/luminance.h"
#include "gpu/commands.h"
#include "gpu/pipeline.h"
#include "render/cloud_air_test.comp.h"
#include "render/frame_setup.h"
#include "render/reference_scene.h"

using namespace nepho;
using namespace nepho::test;

namespace {

/// Thin cloud of opacity 0.3 some 800 m away before thick cloud at 10 km and more, in air with a visibility of 8 km.
Scene black_clouds() {
  CloudLayer thin;
  thin.weather_channel = "b";
  thin.base_m = 400.0;
  thin.thickness_m = 100.0;
  thin.density_scale = 0.035;
  thin.coverage_filter_width = 1.6;
  thin.top_relief = 0.3;
  thin.cover_optical_depth = 0.01;
  CloudLayer thick = thin;
  thick.weather_channel = "r";
  thick.base_m = 2500.0;
  thick.thickness_m = 500.0;
  thick.density_scale = 1.0;
  thick.cover_optical_depth = 1.0;
  CloudParams clouds;
  clouds.coverage = 0.9;
  clouds.layers = {thin, thick};
  clouds.scattering_per_m = 0.0;
  clouds.absorption_per_m = 0.04;
  Scene scene = reference_scene(clouds, {12, 7});
  scene.time = "2026-06-20T22:14:30Z";
  scene.camera.pitch_deg = 14.0;
  scene.camera.fov_deg = 20.0;
  scene.atmosphere.mie.visibility_m = 8e3;
  scene.shafts.method = "none";
  return scene;
}

/// Green luminance of the air up to a distance along every pixel's ray.
std::vector<double> air_before(GpuFixture& gpu, const Scene& scene, const CameraPose& pose,
                               const std::vector<float>& distances_m) {
  struct Place {
    glm::vec2 pixel;
    float distance_m;
  };
  std::vector<Place> places;
  for (uint32_t i = 0; i < distances_m.size(); ++i)
    places.push_back({glm::vec2(i % scene.render.width, i / scene.render.width) + 0.5f, distances_m[i]});
  const AtmosphereTables atmosphere(gpu.device, scene.atmosphere);
  const gpu::ComputePipeline pipeline(
      gpu.device,
      {.name = "cloud_air_test", .spirv = cloud_air_test_comp, .constants = {atmosphere.spectral_groups()}});
  const UtcInstant utc = parse_utc(scene.time);
  const FrameLight light =
      FrameLight::from(sky_bodies_at(utc), sun_illuminance_at_1au(scene.atmosphere), scene.night_sky.moon);
  FrameGraph graph;
  const BufferRef out = graph.create_buffer("airs", places.size() * sizeof(glm::vec3));
  auto pass = graph.pass("cloud_air_test");
  pass.uniform("frame",
               graph.constants("frame", make_frame_constants(pose, {scene.render.width, scene.render.height}, light,
                                                             utc.seconds_since_2000(), 0, 0, glm::vec2(0.0f))))
      .read("places", graph.constants("places", places))
      .write("airs", out);
  AtmosphereTables::bind(pass, atmosphere.add(graph, {}));
  pass.record([&](gpu::Commands& cmd) { cmd.bind(pipeline).dispatch_threads(static_cast<uint32_t>(places.size())); });
  graph.keep(out);
  gpu.executor.run(graph);
  std::vector<double> green;
  for (const glm::vec3& air : gpu.executor.read<glm::vec3>(out)) green.push_back(static_cast<double>(air.g));
  return green;
}

}  // namespace

TEST_CASE(
    "gpu: air before thin cloud over far cloud is the path tracer's within 2 %, where one mean depth is off by 8 %") {
  GpuFixture gpu;
  Scene scene = black_clouds();
  ImageBuffer truth;
  {
    Renderer renderer(gpu.device, {}, scene);
    truth = draw_to(renderer, 130);
  }
  scene.render.quality = "low";
  scene.render.frames = 16;  // the march's noise, as the paths', averaged
  Renderer renderer(gpu.device, {}, scene);
  RenderRequest request;
  request.display = false;
  const RenderResult drawn = renderer.render(request);
  const std::vector<float>&through = channel(drawn.layers, "cloud.transmittance"),
        &depth = channel(drawn.layers, "cloud.depth_m");
  const std::vector<double> air = air_before(gpu, scene, drawn.pose, depth);
  double sum = 0.0, two = 0.0, one = 0.0, near = 0.0;
  for (size_t i = 0; i < depth.size(); ++i) {
    const double opaque = 1.0 - static_cast<double>(through[i]),
                 right = static_cast<double>(channel(truth, "cloud.G")[i]);
    sum += right;
    two += static_cast<double>(channel(drawn.layers, "cloud.G")[i]) - right;
    one += air[i] * opaque - right;
    near += opaque;
  }
  MESSAGE("two depths ", 100.0 * two / sum, " %, one depth ", 100.0 * one / sum, " %, mean opacity ",
          near / static_cast<double>(depth.size()));
  CHECK(near > 0.5 * static_cast<double>(depth.size()));
  CHECK(std::abs(two) < 0.02 * sum);
  CHECK(one > 0.05 * sum);
}
