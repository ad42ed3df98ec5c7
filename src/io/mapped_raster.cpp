#include "io/mapped_raster.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace nepho {

namespace {

class MappedRaster final : public Raster {
 public:
  MappedRaster(std::shared_ptr<Raster> source, const std::array<float, 256>& curve)
      : source_(std::move(source)), curve_(curve), info_(source_->info()) {
    if (info_.fingerprint.empty()) return;
    for (const float v : curve_) info_.fingerprint += fmt::format(" {:08x}", std::bit_cast<uint32_t>(v));
  }
  const RasterInfo& info() const override { return info_; }
  uint32_t reductions() const override { return source_->reductions(); }
  Result<RasterBlock> read_block(uint32_t reduction, uint32_t bx, uint32_t by) const override {
    Result<RasterBlock> block = source_->read_block(reduction, bx, by);
    if (!block) return block;
    const uint32_t bands = info().bands;
    const uint32_t colors = bands == 2 || bands == 4 ? bands - 1 : bands;
    for (size_t i = 0; i < block->values.size(); ++i)
      if (i % bands < colors) block->values[i] = mapped(block->values[i]);
    return block;
  }
  uint32_t pyramid_level(uint32_t reduction) const override { return source_->pyramid_level(reduction); }

 private:
  float mapped(float value) const {
    const float v = std::clamp(value, 0.0f, 255.0f);
    const auto low = std::min(static_cast<size_t>(v), size_t{254});
    const float f = v - static_cast<float>(low);
    return curve_[low] + f * (curve_[low + 1] - curve_[low]);
  }
  std::shared_ptr<Raster> source_;
  std::array<float, 256> curve_;
  RasterInfo info_;
};

}  // namespace

std::shared_ptr<Raster> make_mapped_imagery(std::shared_ptr<Raster> source, const std::array<float, 256>& curve) {
  return std::make_shared<MappedRaster>(std::move(source), curve);
}

std::array<float, 256> albedo_curve(float offset, float scale, float gamma) {
  std::array<float, 256> curve;
  for (size_t i = 0; i < curve.size(); ++i) {
    const float s = std::pow(static_cast<float>(i) / 255.0f, 1.0f / gamma);
    const float linear = s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
    const float albedo = std::clamp(offset + scale * linear, 0.0f, 1.0f);
    curve[i] = 255.0f * (albedo <= 0.0031308f ? 12.92f * albedo : 1.055f * std::pow(albedo, 1.0f / 2.4f) - 0.055f);
  }
  return curve;
}

}  // namespace nepho
