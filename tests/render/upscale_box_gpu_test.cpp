// A box that moves before clouds, written into the depth that the upscaler is given: no pixel keeps what it was.
#include "clouds/cloud_upscaler.h"
#include "gpu/commands.h"
#include "render/frame_setup.h"
#include "render/reference_scene.h"
#include "render/upscale_test.comp.h"

namespace nepho {

TEST_CASE("gpu: a box that moves before clouds leaves no trace: every pixel is what it is without history") {
  GpuFixture gpu;
  const Extent2D size{64, 48};
  const size_t pixels = size_t{size.width} * size.height;
  const Clouds clouds(gpu.device, test::half_sky("cumulus"));
  const gpu::ComputePipeline all(gpu.device, {.name = "test.all", .spirv = upscale_test_comp, .constants = {0}});
  const gpu::ComputePipeline listed(gpu.device, {.name = "test.listed", .spirv = upscale_test_comp, .constants = {1}});
  Scene scene = test::reference_scene(test::half_sky("cumulus"), size);
  const CameraPose pose = resolve_camera(scene.camera, [](double, double) { return 0.0; });
  for (const uint32_t upscale : {2u, 4u, 16u}) {
    CloudUpscaler upscaler(gpu.device, clouds);
    for (uint32_t i = 0; i < 12; ++i) {
      // Bright clouds at 3 km with a texture; the box, 50 m away, hides them where it is.
      std::vector<float> depth(pixels), cloud(4 * pixels), info(4 * pixels);
      for (uint32_t y = 0; y < size.height; ++y)
        for (uint32_t x = 0; x < size.width; ++x) {
          const size_t k = size_t{y} * size.width + x;
          const bool box = x >= 4 + 3 * i && x < 16 + 3 * i && y >= 10 + i && y < 24 + i;
          depth[k] = box ? 50.0f : shared::kFarDepth_m;
          const float bright = 5000.0f + 300.0f * static_cast<float>((7 * x + 13 * y) % 11);
          for (size_t c = 0; c < 3; ++c) cloud[4 * k + c] = box ? 0.0f : bright;
          cloud[4 * k + 3] = box ? 1.0f : 0.25f;
          info[4 * k] = box ? shared::kFarDepth_m : 3000.0f;
        }
      const auto image = [&](const std::vector<float>& values, Format format) {
        gpu::Image made = gpu.device.create_image({.name = "test", .extent = size, .format = format});
        const gpu::ImageUpload upload{&made, std::as_bytes(std::span(values))};
        gpu.device.upload({&upload, 1});
        return made;
      };
      const gpu::Image depth_image = image(depth, Format::r32f), cloud_image = image(cloud, Format::rgba32f),
                       info_image = image(info, Format::rgba32f);
      FrameGraph graph;
      FrameInfo frame;
      frame.extent = size;
      frame.camera_ecef_m = pose.ecef_m;
      frame.constants = make_frame_constants(pose, size, FrameLight{}, 0.0, i, 0, glm::vec2(0.0f));
      frame.buffer = graph.constants("frame", frame.constants);
      const ImageRef depth_m = graph.import(depth_image);
      const CloudUpscaler::Selection selected = upscaler.select(graph, frame, upscale, depth_m, false);
      const ImageDesc desc{.extent = size, .format = Format::rgba32f};
      const ImageRef drawn = selected.first() ? graph.create("drawn", desc) : selected.radiance;
      const ImageRef facts = selected.first() ? graph.create("facts", desc) : selected.info;
      FrameGraph::PassBuilder pass = graph.pass("test.march");
      pass.sample("cloud", graph.import(cloud_image), Sampler::nearest_clamp)
          .sample("info", graph.import(info_image), Sampler::nearest_clamp)
          .write("out_cloud", drawn)
          .write("out_info", facts);
      bind_pixel_list(graph, pass, selected.list, 256);
      pass.record([&, first = selected.first()](gpu::Commands& cmd) {
        if (first)
          cmd.bind(all).dispatch_threads(size.width, size.height);
        else
          cmd.bind(listed).dispatch_indirect();
      });
      const CloudUpscaler::Outputs out =
          upscaler.resolve(graph, frame, selected, {.depth_m = depth_m, .cloud = drawn, .info = facts});
      graph.keep(out.cloud);
      graph.keep(out.info);
      gpu.executor.run(graph);
      const std::vector<float> seen = gpu.executor.read<float>(out.cloud), told = gpu.executor.read<float>(out.info);
      size_t wrong = 0;
      for (size_t k = 0; k < 4 * pixels; ++k)
        wrong += std::abs(seen[k] - cloud[k]) > 1e-3f * std::max(1.0f, cloud[k]) ? 1 : 0;
      CHECK_MESSAGE(wrong == 0, "upscale " << upscale << ", frame " << i << ": " << wrong << " values differ");
    }
  }
}

}  // namespace nepho
