#include "clouds/cloud_noise.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>

#include "base/error.h"
#include "clouds/blue_noise.h"
#include "clouds/cloud_noise.comp.h"
#include "clouds/cloud_noise_shared.h"
#include "clouds/noise_file.h"
#include "gpu/commands.h"
#include "gpu/graph_executor.h"
#include "gpu/pipeline.h"
#include "weather/blob_cache.h"

namespace nepho {
namespace {

constexpr uint64_t kNoiseVersion = 3;  // of what the CPU does here; shaders are part of the key by themselves
static_assert(sizeof(shared::CloudNoisePush) == 8);

struct Recipe {
  const char* name;
  uint32_t kind;
  uint32_t size;
  uint32_t channels;  // made by the shader
  Format format;
  uint32_t bytes_per_channel;
};
constexpr Recipe kField{"clouds.field", shared::kNoiseField, CloudNoise::kFieldSize, 4, Format::rgba16, 2};
constexpr Recipe kCells{"clouds.cells", shared::kNoiseCells, CloudNoise::kCellsSize, 2, Format::rg16, 2};
constexpr Recipe kShape{"clouds.shape", shared::kNoiseShape, 128, 1, Format::r8, 1};
constexpr Recipe kDetail{"clouds.detail", shared::kNoiseDetail, 32, 1, Format::r8, 1};
constexpr Recipe kTurbulence{"clouds.turbulence", shared::kNoiseTurbulence, 64, 3, Format::rgba8, 1};

using Planes = std::vector<std::vector<float>>;

Planes run_generator(gpu::Device& device, const Recipe& recipe) {
  const gpu::ComputePipeline pipeline(device,
                                      {.name = "clouds.noise", .spirv = cloud_noise_comp, .constants = {recipe.kind}});
  FrameGraph graph;
  const uint32_t n = recipe.size;
  const ImageRef raw = graph.create("clouds.noise", {.extent = {n, n, n}, .format = Format::rgba32f});
  graph.pass("clouds.noise").write("out_noise", raw).record([&](gpu::Commands& cmd) {
    cmd.bind(pipeline).push(shared::CloudNoisePush{n, 77u}).dispatch_threads(n, n, n);
  });
  graph.keep(raw);
  gpu::GraphExecutor executor(device);
  executor.run(graph);
  const std::vector<float> texels = executor.read<float>(raw);
  Planes planes(recipe.channels, std::vector<float>(texels.size() / 4));
  for (size_t c = 0; c < planes.size(); ++c)
    for (size_t i = 0; i < planes[c].size(); ++i) planes[c][i] = texels[4 * i + c];
  return planes;
}

/// Raw values as texels. Turbulence is a vector, of one variance, but not of a normal distribution.
MippedVolume make_volume(const Recipe& recipe, Planes planes, uint32_t size, const std::string& origin) {
  const bool vector = recipe.kind == shared::kNoiseTurbulence;
  for (std::vector<float>& plane : planes)
    if (!normalise_volume(plane, !vector))
      throw fail(ErrorKind::input, "{}: a channel holds one value only; noise must vary", origin);
  if (vector) planes.emplace_back(planes[0].size(), MippedVolume::kRange);  // alpha 1
  return make_mips(std::move(planes), size, recipe.bytes_per_channel);
}

MippedVolume generate(gpu::Device& device, const Recipe& recipe) {
  Planes planes = run_generator(device, recipe);
  if (recipe.kind == shared::kNoiseTurbulence) {
    auto curl = curl_of({planes[0], planes[1], planes[2]}, recipe.size);
    for (size_t c = 0; c < 3; ++c) planes[c] = std::move(curl[c]);
  }
  return make_volume(recipe, std::move(planes), recipe.size, recipe.name);
}

/// The built-in volume, from cache_dir() where it is there. The key holds the shader and the device, whose arithmetic
/// may round in its own way.
MippedVolume cached_volume(gpu::Device& device, const Recipe& recipe) {
  const std::string who = device.info().name + device.info().driver;
  const uint64_t key = checksum_of(reinterpret_cast<const std::byte*>(cloud_noise_comp), sizeof cloud_noise_comp) +
                       checksum_of(reinterpret_cast<const std::byte*>(who.data()), who.size()) * 31 + kNoiseVersion;
  const std::string file = std::string(recipe.name) + ".bin";
  const uint32_t channels = bytes_per_texel(recipe.format) / recipe.bytes_per_channel;
  const size_t texels = bytes_of_mips(recipe.size, bytes_per_texel(recipe.format));
  const size_t mips = full_mip_levels({recipe.size, recipe.size, recipe.size});
  MippedVolume volume{.size = recipe.size, .texels = {}, .variances = std::vector<float>(mips * channels)};
  const size_t tail = volume.variances.size() * sizeof(float);
  if (std::optional<std::vector<std::byte>> blob = load_cached_blob(file, key); blob && blob->size() == texels + tail) {
    std::memcpy(volume.variances.data(), blob->data() + texels, tail);
    blob->resize(texels);
    volume.texels = std::move(*blob);
    return volume;
  }
  volume = generate(device, recipe);
  std::vector<std::byte> blob = volume.texels;
  blob.resize(texels + tail);
  std::memcpy(blob.data() + texels, volume.variances.data(), tail);
  store_cached_blob(file, key, blob);
  return volume;
}

MippedVolume volume_of(gpu::Device& device, const Recipe& recipe, const std::string& file) {
  if (file.empty()) return cached_volume(device, recipe);
  NoiseVolumeFile read = read_noise_volume(file, recipe.channels);
  return make_volume(recipe, std::move(read.planes), read.size, file);
}

gpu::Image upload_volume(gpu::Device& device, const Recipe& recipe, const MippedVolume& volume) {
  const Extent3D extent{volume.size, volume.size, volume.size};
  const uint32_t mips = full_mip_levels(extent);
  gpu::Image image =
      device.create_image({.name = recipe.name, .extent = extent, .format = recipe.format, .mip_levels = mips});
  std::vector<gpu::ImageUpload> uploads;
  size_t offset = 0;
  for (uint32_t mip = 0, n = volume.size; mip < mips; ++mip, n /= 2) {
    const size_t bytes = size_t{n} * n * n * bytes_per_texel(recipe.format);
    uploads.push_back({.image = &image, .bytes = std::span(volume.texels).subspan(offset, bytes), .mip = mip});
    offset += bytes;
  }
  device.upload(uploads);
  return image;
}

/// Variances by mip: the mean of the channels first..first + count.
std::vector<float> variances_of(const MippedVolume& volume, size_t channels, size_t first, size_t count) {
  std::vector<float> variances(volume.variances.size() / channels, 0.0f);
  for (size_t mip = 0; mip < variances.size(); ++mip)
    for (size_t c = first; c < first + count; ++c)
      variances[mip] += volume.variances[mip * channels + c] / static_cast<float>(count);
  return variances;
}

float variance_left(float lod, float start, float per_lod) {
  const float u = std::clamp((lod - start) * per_lod, 0.0f, 1.0f);
  return 1.0f - u * u * (3.0f - 2.0f * u);
}

/// A small exhaustive fit of the largest error.
CloudNoise::Fade fit_fade(const std::vector<float>& variances) {
  CloudNoise::Fade fade;
  float best = 1e9f;
  for (int s = -40; s < 100; ++s)
    for (int w = 10; w < 120; ++w) {
      const float start = 0.05f * static_cast<float>(s), per_lod = 1.0f / (0.05f * static_cast<float>(w));
      float error = 0.0f;
      for (size_t mip = 0; mip < variances.size(); ++mip)
        error = std::max(error, std::abs(variance_left(static_cast<float>(mip), start, per_lod) - variances[mip]));
      if (error < best) {
        best = error;
        fade = {start, per_lod};
      }
    }
  return fade;
}

gpu::Image upload_blue_noise(gpu::Device& device, const std::string& file) {
  std::vector<uint8_t> noise;
  if (file.empty()) {
    constexpr size_t kBytes = size_t{kBlueSize} * kBlueSize * kBlueSlices;
    const auto blob = load_cached_blob("clouds.blue.bin", kNoiseVersion);
    if (blob && blob->size() == kBytes) {
      noise.resize(kBytes);
      std::memcpy(noise.data(), blob->data(), kBytes);
    } else {
      noise = make_blue_noise();
      const auto bytes = std::as_bytes(std::span(noise));
      store_cached_blob("clouds.blue.bin", kNoiseVersion, {bytes.begin(), bytes.end()});
    }
  } else {
    noise = read_blue_noise(file);
  }
  gpu::Image image = device.create_image(
      {.name = "clouds.blue", .extent = {kBlueSize, kBlueSize, 1}, .format = Format::r8, .layers = kBlueSlices});
  std::vector<gpu::ImageUpload> uploads;
  constexpr size_t kSlice = size_t{kBlueSize} * kBlueSize;
  for (uint32_t layer = 0; layer < kBlueSlices; ++layer)
    uploads.push_back(
        {.image = &image, .bytes = std::as_bytes(std::span(noise)).subspan(layer * kSlice, kSlice), .layer = layer});
  device.upload(uploads);
  return image;
}

}  // namespace

CloudNoise::CloudNoise(gpu::Device& device, const CloudNoiseParams& params) {
  const auto make = [&](gpu::Image& image, const Recipe& recipe, const std::string& file) {
    MippedVolume volume = volume_of(device, recipe, file);
    image = upload_volume(device, recipe, volume);
    return volume;
  };
  // Files first: what is wrong with them should show before anything is made.
  const MippedVolume shape = make(shape_, kShape, params.shape.file);
  const MippedVolume detail = make(detail_, kDetail, params.detail.file);
  make(turbulence_, kTurbulence, params.turbulence.file);
  blue_ = upload_blue_noise(device, params.blue_noise_file);
  const MippedVolume field = make(field_, kField, "");
  const MippedVolume cells = make(cells_, kCells, "");
  variances_ = {variances_of(field, 4, 0, 4), variances_of(cells, 2, 0, 1), variances_of(cells, 2, 1, 1),
                variances_of(shape, 1, 0, 1), variances_of(detail, 1, 0, 1)};
  fades_ = {.field = fit_fade(variances_[0]),
            .cells_round = fit_fade(variances_[1]),
            .cells_fractal = fit_fade(variances_[2]),
            .shape = fit_fade(variances_[3]),
            .detail = fit_fade(variances_[4])};
}

CloudNoise::Refs CloudNoise::import_into(FrameGraph& graph) const {
  return {graph.import(field_),  graph.import(cells_),      graph.import(shape_),
          graph.import(detail_), graph.import(turbulence_), graph.import(blue_)};
}

uint32_t CloudNoise::shape_size() const { return shape_.desc().extent.width; }
uint32_t CloudNoise::detail_size() const { return detail_.desc().extent.width; }
uint32_t CloudNoise::turbulence_size() const { return turbulence_.desc().extent.width; }

}  // namespace nepho
