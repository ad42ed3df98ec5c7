#include "clouds/cloud_noise.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "clouds/blue_noise.h"
#include "clouds/cloud_noise.comp.h"
#include "clouds/cloud_noise_shared.h"
#include "clouds/clouds_shared.h"
#include "clouds/noise_file.h"
#include "clouds/noise_recipe.h"
#include "gpu/commands.h"
#include "gpu/graph_executor.h"
#include "gpu/pipeline.h"
#include "base/blob_cache.h"

namespace nepho {
namespace {

constexpr uint64_t kNoiseVersion = 6;  // of what the CPU does here; shaders are part of the key by themselves
static_assert(sizeof(shared::NoiseTerm) == 80);

using Planes = std::vector<std::vector<float>>;

struct Volume {
  const char* name;
  uint32_t size;
  Format format;
  uint32_t bytes_per_channel;
  std::vector<NoiseRecipe> channels;
  bool vector = false;  ///< three channels are a vector potential, and the volume its curl
};

const Volume& field_volume() {
  static const NoiseRecipe fractal{{.cycles = 4, .count = 5, .gain = 0.62f}};
  static const Volume volume{
      "clouds.field", CloudNoise::kFieldSize, Format::rgba16, 2, {fractal, fractal, fractal, fractal}};
  return volume;
}
const Volume& cells_volume() {
  static const NoiseRecipe round{{.cycles = 9, .amplitude = 0.6f, .domes = true, .bend = 0.02f},
                                 {.cycles = 17, .amplitude = 0.4f, .domes = true, .bend = 0.02f},
                                 {.cycles = 7, .count = 3, .gain = 0.6f, .amplitude = 0.45f}};
  static const NoiseRecipe fractal{{.cycles = 8, .count = 4, .gain = 0.6f}};
  static const Volume volume{"clouds.cells", CloudNoise::kCellsSize, Format::rg16, 2, {round, fractal}};
  return volume;
}
const Volume& shape_volume() {
  static const NoiseRecipe billows{{.cycles = 8, .amplitude = 0.54f, .domes = true, .bend = 0.02f},
                                   {.cycles = 17, .amplitude = 0.30f, .domes = true, .bend = 0.02f},
                                   {.cycles = 35, .amplitude = 0.17f, .domes = true, .bend = 0.02f},
                                   {.cycles = 7, .count = 3, .gain = 0.55f, .amplitude = 0.3f}};
  static const Volume volume{"clouds.shape", 128, Format::r16, 2, {billows}};
  return volume;
}
const Volume& detail_volume() {
  static const NoiseRecipe billows{{.cycles = 4, .count = 2, .gain = 0.61f, .domes = true}};
  static const Volume volume{"clouds.detail", 32, Format::r16, 2, {billows}};
  return volume;
}
const Volume& turbulence_volume() {
  static const NoiseRecipe potential{{.cycles = 4, .count = 3, .gain = 0.35f}};
  static const Volume volume{"clouds.turbulence", 64, Format::rgba16, 2, {potential, potential, potential}, true};
  return volume;
}

/// Raw values as texels. Turbulence is a vector, of one variance, but not of a normal distribution.
MippedVolume make_volume(const Volume& volume, Planes planes, uint32_t size, const std::string& origin) {
  for (std::vector<float>& plane : planes)
    if (!normalise_volume(plane, !volume.vector))
      throw fail(ErrorKind::input, "{}: a channel holds one value only; noise must vary", origin);
  if (volume.vector) planes.emplace_back(planes[0].size(), MippedVolume::kRange);  // alpha 1
  return make_mips(std::move(planes), size, volume.bytes_per_channel);
}

/// Makes built-in volumes; the shader is compiled when it is first needed.
class Generator {
 public:
  explicit Generator(gpu::Device& device) : device_(device), executor_(device) {}
  /// The volume, from the cache where it is there. The key holds the shader and the recipe; the device's arithmetic may
  /// round in its own way.
  MippedVolume cached(const Volume& volume) {
    std::vector<std::vector<NoiseDispatch>> channels;
    const uint64_t who = checksum(std::string_view(device_.info().name + device_.info().driver));
    uint64_t key = kNoiseVersion + checksum(std::span(cloud_noise_comp));
    for (uint32_t c = 0; c < volume.channels.size(); ++c) {
      const auto name = static_cast<uint32_t>(checksum(std::string_view(volume.name)));
      channels.push_back(noise_dispatches(volume.channels[c], volume.size, name + c));
      for (const NoiseDispatch& octave : channels.back())
        key = 131 * key + checksum(std::span(&octave.term, 1)) + octave.dome;
    }
    const std::string file = std::string(volume.name) + ".bin";
    const size_t texels = bytes_of_mips(volume.size, bytes_per_texel(volume.format));
    const size_t mips = full_mip_levels({volume.size, volume.size, volume.size});
    MippedVolume made{.size = volume.size, .texels = {}, .variances = {}};
    made.variances.resize(mips * bytes_per_texel(volume.format) / volume.bytes_per_channel);
    const size_t tail = made.variances.size() * sizeof(float);
    if (auto blob = load_cached_blob(file, key, who); blob && blob->size() == texels + tail) {
      std::memcpy(made.variances.data(), blob->data() + texels, tail);
      blob->resize(texels);
      made.texels = std::move(*blob);
      return made;
    }
    made = generate(volume, channels);
    std::vector<std::byte> blob = made.texels;
    blob.resize(texels + tail);
    std::memcpy(blob.data() + texels, made.variances.data(), tail);
    store_cached_blob(file, key, blob, who);
    return made;
  }

 private:
  template <typename Range>
  static uint64_t checksum(const Range& range) {
    const auto bytes = std::as_bytes(std::span(range));
    return checksum_of(bytes.data(), bytes.size());
  }
  std::vector<float> sum_of(const std::vector<NoiseDispatch>& octaves, uint32_t size) {
    FrameGraph graph;
    const ImageRef sum = graph.create("clouds.noise", {.extent = {size, size, size}, .format = Format::r32f});
    graph.pass("clouds.noise_clear").fill("sum", sum).record([](gpu::Commands& cmd) { cmd.fill("sum", 0.0f); });
    for (const NoiseDispatch& octave : octaves) {
      gpu::ComputePipeline& pipeline = pipelines_[octave.dome];
      if (!pipeline)
        pipeline = gpu::ComputePipeline(
            device_, {.name = "clouds.noise", .spirv = cloud_noise_comp, .constants = {octave.dome ? 1u : 0u}});
      graph.pass("clouds.noise").read_write("sum", sum).record([&](gpu::Commands& cmd) {
        cmd.bind(pipeline).push(octave.term).dispatch_threads(size, size, size);
      });
    }
    graph.keep(sum);
    executor_.run(graph);
    return executor_.read<float>(sum);
  }
  MippedVolume generate(const Volume& volume, const std::vector<std::vector<NoiseDispatch>>& channels) {
    Planes planes;
    for (const std::vector<NoiseDispatch>& octaves : channels) planes.push_back(sum_of(octaves, volume.size));
    if (volume.vector) {
      auto curl = curl_of({planes[0], planes[1], planes[2]}, volume.size);
      for (size_t c = 0; c < 3; ++c) planes[c] = std::move(curl[c]);
    } else {
      decorrelate(planes);
    }
    return make_volume(volume, std::move(planes), volume.size, volume.name);
  }
  gpu::Device& device_;
  gpu::GraphExecutor executor_;
  gpu::ComputePipeline pipelines_[2];
};

MippedVolume volume_of(Generator& generator, const Volume& volume, const std::string& file) {
  if (file.empty()) return generator.cached(volume);
  NoiseVolumeFile read = read_noise_volume(file, static_cast<uint32_t>(volume.channels.size()));
  return make_volume(volume, std::move(read.planes), read.size, file);
}

gpu::Image upload_volume(gpu::Device& device, const Volume& volume, const MippedVolume& made) {
  const Extent3D extent{made.size, made.size, made.size};
  const uint32_t mips = full_mip_levels(extent);
  gpu::Image image =
      device.create_image({.name = volume.name, .extent = extent, .format = volume.format, .mip_levels = mips});
  std::vector<gpu::ImageUpload> uploads;
  size_t offset = 0;
  for (uint32_t mip = 0, n = made.size; mip < mips; ++mip, n /= 2) {
    const size_t bytes = size_t{n} * n * n * bytes_per_texel(volume.format);
    uploads.push_back({.image = &image, .bytes = std::span(made.texels).subspan(offset, bytes), .mip = mip});
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

/// A small exhaustive fit of the largest error.
CloudNoise::Fade fit_fade(const std::vector<float>& variances) {
  CloudNoise::Fade fade;
  float best = 1e9f;
  for (int s = -40; s < 100; ++s)
    for (int w = 10; w < 120; ++w) {
      const float start = 0.05f * static_cast<float>(s), per_lod = 1.0f / (0.05f * static_cast<float>(w));
      float error = 0.0f;
      for (size_t mip = 0; mip < variances.size(); ++mip)
        error =
            std::max(error, std::abs(shared::variance_left(static_cast<float>(mip), start, per_lod) - variances[mip]));
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
  Generator generator(device);
  const auto make = [&](gpu::Image& image, const Volume& volume, const std::string& file) {
    MippedVolume made = volume_of(generator, volume, file);
    image = upload_volume(device, volume, made);
    return made;
  };
  // Files first: what is wrong with them should show before anything is made.
  const MippedVolume shape = make(shape_, shape_volume(), params.shape.file);
  const MippedVolume detail = make(detail_, detail_volume(), params.detail.file);
  make(turbulence_, turbulence_volume(), params.turbulence.file);
  blue_ = upload_blue_noise(device, params.blue_noise_file);
  const MippedVolume field = make(field_, field_volume(), "");
  const MippedVolume cells = make(cells_, cells_volume(), "");
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
