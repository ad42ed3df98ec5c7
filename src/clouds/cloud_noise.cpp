#include "clouds/cloud_noise.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "clouds/cloud_noise.comp.h"
#include "clouds/clouds_shared.h"
#include "gpu/commands.h"
#include "gpu/graph_executor.h"
#include "gpu/pipeline.h"
#include "weather/blob_cache.h"
#include "weather/weather_map.h"

namespace nepho {
namespace {

constexpr uint64_t kNoiseVersion = 2;
constexpr float kRange = 4.0f;  // kNoiseRange in cloud_density.glsl
static_assert(sizeof(shared::CloudNoisePush) == 12);

struct Volume {
  const char* name;
  uint32_t kind;
  uint32_t size;
  uint32_t channels;
  Format format;
  uint32_t bytes_per_channel;
  uint32_t first_variance;  // component of variance()
  bool gaussian;
};
constexpr Volume kVolumes[] = {
    {"clouds.field", shared::kCloudNoiseField, 128, 2, Format::rg16, 2, 0, true},
    {"clouds.shape", shared::kCloudNoiseShape, 128, 1, Format::r8, 1, 2, false},
    {"clouds.detail", shared::kCloudNoiseDetail, 32, 1, Format::r8, 1, 3, false},
};

size_t texels_of(uint32_t size) { return size_t{size} * size * size; }

std::vector<float> run_generator(gpu::Device& device, const gpu::ComputePipeline& pipeline, const Volume& volume) {
  FrameGraph graph;
  const uint32_t n = volume.size;
  const ImageRef raw = graph.create("clouds.noise", {.extent = {n, n, n}, .format = Format::rg32f});
  graph.pass("clouds.noise").write("out_noise", raw).record([&](gpu::Commands& cmd) {
    cmd.bind(pipeline).push(shared::CloudNoisePush{volume.kind, n, 77u + volume.kind}).dispatch_threads(n, n, n);
  });
  graph.keep(raw);
  gpu::GraphExecutor executor(device);
  executor.run(graph);
  return executor.read<float>(raw);
}

/// All mips as texels, one after the other; then the variances, mip by mip and channel by channel, as floats.
std::vector<std::byte> make_blob(const Volume& volume, const std::vector<float>& raw) {
  const size_t count = texels_of(volume.size);
  std::vector<std::vector<float>> level(volume.channels, std::vector<float>(count));
  for (uint32_t c = 0; c < volume.channels; ++c) {
    for (size_t i = 0; i < count; ++i) level[c][i] = raw[2 * i + c];
    normalise_volume(level[c], volume.gaussian);
  }
  std::vector<std::byte> blob;
  std::vector<float> variances;
  for (uint32_t n = volume.size; n >= 1; n /= 2) {
    const size_t offset = blob.size();
    blob.resize(offset + texels_of(n) * volume.channels * volume.bytes_per_channel);
    for (uint32_t c = 0; c < volume.channels; ++c) {
      double square = 0.0;
      for (size_t i = 0; i < texels_of(n); ++i) {
        square += static_cast<double>(level[c][i]) * level[c][i];
        const float unit = std::clamp(0.5f + level[c][i] / (2.0f * kRange), 0.0f, 1.0f);
        std::byte* to = &blob[offset + (i * volume.channels + c) * volume.bytes_per_channel];
        if (volume.bytes_per_channel == 1) {
          *to = static_cast<std::byte>(static_cast<int>(unit * 255.0f + 0.5f));
        } else {
          const auto word = static_cast<uint16_t>(unit * 65535.0f + 0.5f);
          std::memcpy(to, &word, 2);
        }
      }
      variances.push_back(static_cast<float>(square / static_cast<double>(texels_of(n))));
      level[c] = half_volume(level[c], n);
    }
  }
  const size_t offset = blob.size();
  blob.resize(offset + variances.size() * sizeof(float));
  std::memcpy(&blob[offset], variances.data(), variances.size() * sizeof(float));
  return blob;
}

}  // namespace

void normalise_volume(std::vector<float>& values, bool gaussian) {
  if (gaussian) {
    std::vector<uint32_t> order(values.size());
    for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return values[a] != values[b] ? values[a] < values[b] : a < b; });
    for (size_t rank = 0; rank < order.size(); ++rank)
      values[order[rank]] =
          static_cast<float>(exact_probit((static_cast<double>(rank) + 0.5) / static_cast<double>(order.size())));
    return;
  }
  double mean = 0.0, square = 0.0;
  for (const float v : values) mean += v;
  mean /= static_cast<double>(values.size());
  for (const float v : values) square += (v - mean) * (v - mean);
  const double scale = 1.0 / std::sqrt(std::max(square / static_cast<double>(values.size()), 1e-20));
  for (float& v : values) v = static_cast<float>((v - mean) * scale);
}

std::vector<float> half_volume(const std::vector<float>& values, uint32_t size) {
  if (size <= 1) return values;
  const uint32_t half = size / 2;
  std::vector<float> next(texels_of(half));
  for (size_t z = 0, i = 0; z < half; ++z)
    for (size_t y = 0; y < half; ++y)
      for (size_t x = 0; x < half; ++x, ++i) {
        float sum = 0.0f;
        for (size_t k = 0; k < 8; ++k)
          sum += values[((2 * z + (k >> 2)) * size + 2 * y + ((k >> 1) & 1)) * size + 2 * x + (k & 1)];
        next[i] = sum / 8.0f;
      }
  return next;
}

CloudNoise::CloudNoise(gpu::Device& device) {
  gpu::ComputePipeline pipeline;
  for (const Volume& volume : kVolumes) {
    const uint32_t mips = full_mip_levels({volume.size, volume.size, volume.size});
    size_t expected = mips * volume.channels * sizeof(float);
    for (uint32_t n = volume.size; n >= 1; n /= 2)
      expected += texels_of(n) * volume.channels * volume.bytes_per_channel;
    const std::string file = std::string(volume.name) + ".bin";
    std::optional<std::vector<std::byte>> blob = load_cached_blob(file, kNoiseVersion);
    if (!blob || blob->size() != expected) {
      if (!pipeline) pipeline = gpu::ComputePipeline(device, {.name = "clouds.noise", .spirv = cloud_noise_comp});
      blob = make_blob(volume, run_generator(device, pipeline, volume));
      store_cached_blob(file, kNoiseVersion, *blob);
    }
    gpu::Image image = device.create_image({.name = volume.name,
                                            .extent = {volume.size, volume.size, volume.size},
                                            .format = volume.format,
                                            .mip_levels = mips});
    std::vector<gpu::ImageUpload> uploads;
    size_t offset = 0;
    for (uint32_t mip = 0, n = volume.size; mip < mips; ++mip, n /= 2) {
      const size_t bytes = texels_of(n) * volume.channels * volume.bytes_per_channel;
      uploads.push_back({.image = &image, .bytes = std::span(*blob).subspan(offset, bytes), .mip = mip});
      offset += bytes;
    }
    device.upload(uploads);
    for (uint32_t mip = 0; mip < mips && mip < variance_.size(); ++mip)
      for (uint32_t c = 0; c < volume.channels; ++c)
        std::memcpy(&variance_[mip][static_cast<int>(volume.first_variance + c)],
                    &(*blob)[offset + (mip * volume.channels + c) * sizeof(float)], sizeof(float));
    (volume.kind == shared::kCloudNoiseField   ? field_
     : volume.kind == shared::kCloudNoiseShape ? shape_
                                               : detail_) = std::move(image);
  }
  // A small exhaustive fit: two numbers per noise.
  for (int c = 0; c < 4; ++c) {
    float best = 1e9f;
    for (float start = -1.0f; start < 4.0f; start += 0.05f)
      for (float width = 1.0f; width < 9.0f; width += 0.05f) {
        float error = 0.0f;
        for (size_t mip = 0; mip < variance_.size(); ++mip) {
          const float d = shared::variance_left(static_cast<float>(mip), start, 1.0f / width) - variance_[mip][c];
          error += d * d;
        }
        if (error < best) {
          best = error;
          fade_start_[c] = start;
          fade_per_lod_[c] = 1.0f / width;
        }
      }
  }
}

}  // namespace nepho
