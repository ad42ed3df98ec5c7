#include "terrain/night_lights.h"

#include <algorithm>
#include <vector>

#include "base/parallel.h"
#include "terrain/imagery_sampler.h"

namespace nepho {

namespace {
constexpr uint32_t kNightWidth = 2048;
}

gpu::Image make_night_lights(gpu::Device& device, const std::shared_ptr<Raster>& raster, const RasterCaches& caches) {
  const uint32_t width = raster ? kNightWidth : 1, height = std::max(1u, width / 2);
  const Extent3D extent{width, height};
  std::vector<float> rgbx(size_t{width} * height * 4, 0.0f);
  if (raster) {
    const BlockCache blocks(raster, caches);
    std::vector<double> lon(width);
    for (uint32_t i = 0; i < width; ++i) lon[i] = -180.0 + 360.0 * (i + 0.5) / width;
    const uint32_t k = blocks.reduction_for(360.0 / width);
    parallel_for(height, [&](size_t j) {
      const double lat[] = {90.0 - 180.0 * (static_cast<double>(j) + 0.5) / height};
      lay_over(blocks, k, lat, lon, &rgbx[j * width * 4]);
    });
  }
  std::vector<std::vector<uint8_t>> mips(1);
  for (const float v : rgbx) mips[0].push_back(static_cast<uint8_t>(std::clamp(v, 0.0f, 255.0f) + 0.5f));
  uint32_t w = width, h = height;
  while (w > 1 && h > 1) {
    const std::vector<uint8_t>& from = mips.back();
    std::vector<uint8_t> to(size_t{w / 2} * (h / 2) * 4);
    for (size_t j = 0; j < h / 2; ++j)
      for (size_t i = 0; i < w / 2 * 4; ++i) {
        const size_t at = 2 * j * w * 4 + (i / 4) * 8 + i % 4;
        to[j * (w / 2) * 4 + i] =
            static_cast<uint8_t>((from[at] + from[at + 4] + from[at + w * 4] + from[at + w * 4 + 4] + 2) / 4);
      }
    mips.push_back(std::move(to));
    w /= 2;
    h /= 2;
  }
  const auto levels = static_cast<uint32_t>(mips.size());
  gpu::Image image = device.create_image(
      {.name = "terrain.night_lights", .extent = extent, .format = Format::rgba8_srgb, .mip_levels = levels});
  std::vector<gpu::ImageUpload> uploads;
  for (uint32_t m = 0; m < levels; ++m) uploads.push_back({&image, std::as_bytes(std::span(mips[m])), m, 0});
  device.upload(uploads);
  return image;
}

}  // namespace nepho
