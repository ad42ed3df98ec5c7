#include "gpu/gpu_fixture.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "gpu/commands.h"
#include "gpu/pipeline_cache.h"
#include "gpu/test_add.comp.h"
#include "gpu/test_blur.comp.h"
#include "gpu/test_triangle.frag.h"
#include "gpu/test_triangle.vert.h"

using namespace nepho;
namespace fs = std::filesystem;

namespace {
struct AddPush {
  float unused[3] = {0, 0, 0};
  float scale = 1.0f;
};

struct AddFrame {
  FrameGraph graph;
  ImageRef image;
  BufferRef sums;
};

AddFrame make_add_frame(const gpu::ComputePipeline& add, const gpu::ComputePipeline& sum, float base) {
  AddFrame f;
  const float settings = base;
  const BufferRef constants = f.graph.constants("settings", settings);
  f.image = f.graph.create_history("accumulated", {.extent = {8, 4}, .format = Format::r32f});
  f.sums = f.graph.create_buffer("sums", 4 * sizeof(float));
  f.graph.pass("add")
      .uniform("settings", constants)
      .write("result", f.image)
      .sample_history("last", f.image)
      .record([&add](gpu::Commands& cmd) { cmd.bind(add).push(AddPush{}).dispatch_threads(8, 4); });
  f.graph.pass("sum").sample("source", f.image).write("sums", f.sums).record([&sum](gpu::Commands& cmd) {
    cmd.bind(sum).dispatch_threads(4);
  });
  f.graph.keep(f.sums);
  return f;
}
}  // namespace

TEST_CASE("shader reflection: names, kinds, push constants and workgroup size come out of the SPIR-V") {
  const gpu::ShaderReflection r = gpu::reflect(test_add_comp);
  CHECK(r.group_size[0] == 8);
  CHECK(r.group_size[1] == 4);
  CHECK(r.push_constant_bytes == 16);
  REQUIRE(r.find("settings") != nullptr);
  CHECK(r.find("settings")->kind == gpu::BindingKind::uniform_buffer);
  REQUIRE(r.find("result") != nullptr);
  CHECK(r.find("result")->kind == gpu::BindingKind::storage_image);
  REQUIRE(r.find("last") != nullptr);
  CHECK(r.find("last")->kind == gpu::BindingKind::sampled_image);
  const uint32_t junk[] = {1, 2, 3, 4};
  CHECK_THROWS_AS(gpu::reflect(junk), Error);
}

TEST_CASE("gpu: two frames in one command buffer accumulate through history, without a validation message") {
  GpuFixture gpu;
  const gpu::ComputePipeline add(gpu.device, {.name = "test.add", .spirv = test_add_comp});
  const gpu::ComputePipeline sum(gpu.device, {.name = "test.sum", .spirv = test_blur_comp});
  const AddFrame first = make_add_frame(add, sum, 1.0f), second = make_add_frame(add, sum, 2.0f);
  gpu.executor.run({&first.graph, &second.graph});
  const std::vector<float> sums = gpu.executor.read<float>(second.sums);
  REQUIRE(sums.size() == 4);
  // Row y holds 1 + x + 100 y plus 2 + x + 100 y for x = 0..7: 8 * 3 + 2 * 28 + 1600 y.
  for (size_t y = 0; y < 4; ++y) CHECK(sums[y] == 80.0f + 1600.0f * static_cast<float>(y));
  REQUIRE(gpu.executor.timings().size() == 4);
  CHECK(gpu.executor.timings()[0].name == "add");

  // A third frame on its own goes on from there.
  const AddFrame third = make_add_frame(add, sum, 0.0f);
  gpu.executor.run(third.graph);
  CHECK(gpu.executor.read<float>(third.sums)[0] == 80.0f + 28.0f);
}

TEST_CASE("gpu: a shader binding that the pass does not declare is an error that names both") {
  GpuFixture gpu;
  const gpu::ComputePipeline sum(gpu.device, {.name = "test.sum", .spirv = test_blur_comp});
  FrameGraph graph;
  const BufferRef sums = graph.create_buffer("sums", 16);
  graph.pass("forgetful").write("sums", sums).record([&](gpu::Commands& cmd) { cmd.bind(sum).dispatch_threads(4); });
  graph.keep(sums);
  std::string text;
  try {
    gpu.executor.run(graph);
  } catch (const Error& e) {
    text = e.what();
  }
  CHECK(text.find("forgetful") != std::string::npos);
  CHECK(text.find("source") != std::string::npos);
}

TEST_CASE("gpu: upload and download keep every byte of every mip and layer") {
  GpuFixture gpu;
  const gpu::Image image = gpu.device.create_image(
      {.name = "layers", .extent = {4, 4}, .format = Format::rgba8, .mip_levels = 2, .layers = 3});
  std::vector<std::byte> level0(64), level1(16);
  for (size_t i = 0; i < level0.size(); ++i) level0[i] = static_cast<std::byte>(i);
  for (size_t i = 0; i < level1.size(); ++i) level1[i] = static_cast<std::byte>(200 + i);
  std::vector<gpu::ImageUpload> uploads;
  for (uint32_t layer = 0; layer < 3; ++layer) {
    uploads.push_back({&image, level0, 0, layer});
    uploads.push_back({&image, level1, 1, layer});
  }
  gpu.device.upload(uploads);
  const std::vector<std::byte> all0 = gpu.device.download(image, 0), all1 = gpu.device.download(image, 1);
  REQUIRE(all0.size() == 192);
  REQUIRE(all1.size() == 48);
  CHECK(std::equal(level0.begin(), level0.end(), all0.begin() + 128));
  CHECK(std::equal(level1.begin(), level1.end(), all1.begin() + 32));
}

TEST_CASE("gpu: a triangle pulled from a buffer is rastered with reversed depth into an integer target") {
  GpuFixture gpu;
  const gpu::GraphicsPipeline pipeline(gpu.device, {.name = "test.triangle",
                                                    .vertex_spirv = test_triangle_vert,
                                                    .fragment_spirv = test_triangle_frag,
                                                    .color_formats = {Format::rg32u},
                                                    .cull_back = false});
  // Covers the left half of the screen: clip x from -1 to 0.
  const float vertices[4][4] = {{-1, -1, 0.5f, 1}, {0, -1, 0.5f, 1}, {-1, 1, 0.5f, 1}, {0, 1, 0.5f, 1}};
  const uint32_t indices[] = {0, 1, 2, 2, 1, 3};
  FrameGraph graph;
  const BufferRef v = graph.constants("vertices", vertices, sizeof(vertices));
  const BufferRef i = graph.constants("indices", indices, sizeof(indices));
  const ImageRef color = graph.create("color", {.extent = {8, 4}, .format = Format::rg32u});
  const ImageRef depth = graph.create("depth", {.extent = {8, 4}, .format = Format::d32f});
  graph.pass("draw").read("vertices", v).index_buffer(i).color(color).depth(depth).record([&](gpu::Commands& cmd) {
    cmd.bind(pipeline).draw_indexed(6);
  });
  graph.keep(color);
  graph.keep(depth);
  gpu.executor.run(graph);
  const std::vector<uint32_t> texels = gpu.executor.read<uint32_t>(color);
  const std::vector<float> depths = gpu.executor.read<float>(depth);
  for (size_t y = 0; y < 4; ++y)
    for (size_t x = 0; x < 8; ++x) {
      CHECK(texels[2 * (8 * y + x)] == (x < 4 ? x : 0));
      CHECK(texels[2 * (8 * y + x) + 1] == (x < 4 ? 7u : 0u));
      CHECK(depths[8 * y + x] == (x < 4 ? 0.5f : 0.0f));
    }
}

TEST_CASE("gpu: asking for a device that is not there is an error of kind device that lists what is") {
  try {
    gpu::Device device({.device = "no such gpu"});
    FAIL("no error");
  } catch (const Error& e) {
    CHECK(e.exit_status() == 4);
    CHECK(std::string(e.what()).find("no such gpu") != std::string::npos);
  }
}

TEST_CASE("gpu: compiled pipelines are kept on disk, and a torn file is as good as none") {
  const fs::path folder = fs::temp_directory_path() / fmt::format("nepho_pipelines_{}", getpid());
  fs::create_directories(folder);
  const std::string before = std::getenv("NEPHO_CACHE") ? std::getenv("NEPHO_CACHE") : "";
  setenv("NEPHO_CACHE", folder.c_str(), 1);
  const auto kept = [&] {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    REQUIRE(files.size() == 1);
    return files[0];
  };
  const auto loaded = [](gpu::Device& device) {
    return gpu::PipelineCache(device.physical(), device.handle()).loaded_bytes();
  };
  {
    gpu::Device device;
    const gpu::ComputePipeline add(device, {.name = "test.add", .spirv = test_add_comp});
  }
  const uintmax_t size = fs::file_size(kept());
  {
    gpu::Device device;
    CHECK(loaded(device) > 0);
    CHECK(loaded(device) < size);  // less a header
  }
  fs::resize_file(kept(), size - 1);
  {
    gpu::Device device;
    CHECK(loaded(device) == 0);
    const gpu::ComputePipeline add(device, {.name = "test.add", .spirv = test_add_comp});
  }
  CHECK(fs::file_size(kept()) == size);  // made anew
  fs::remove_all(folder);
  if (before.empty())
    unsetenv("NEPHO_CACHE");
  else
    setenv("NEPHO_CACHE", before.c_str(), 1);
}

TEST_CASE("gpu: objects give their memory back") {
  GpuFixture gpu;
  const uint64_t before = gpu.device.memory_bytes();
  {
    const gpu::Image image = gpu.device.create_image({.name = "big", .extent = {256, 256}, .format = Format::rgba32f});
    CHECK(gpu.device.memory_bytes() >= before + 1024u * 1024u);
  }
  CHECK(gpu.device.memory_bytes() == before);
}
