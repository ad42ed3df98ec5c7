#pragma once
#include <cstdint>
#include <vector>

#include "gpu/frame_graph.h"

namespace nepho {

/// What a weather map is made from.
struct WeatherSettings {
  double coverage = 0.4;  ///< mean share of sky covered over the globe, 0..1
  double contrast = 0.75;  ///< CloudParams::weather_contrast, 0..0.95
  uint32_t seed = 1;
  bool operator==(const WeatherSettings&) const = default;
};

/// Local coverage where the large-scale field has the rank `rank` (0..1, uniform over the globe's area). The whole
/// field is contrast x large scale + sqrt(1 - contrast^2) x small scales, both standard normal, so that thresholding it
/// at the probit of `coverage` gives exactly that mean for every contrast. 0 and 1 stay 0 and 1.
double local_coverage(double rank, const WeatherSettings& settings);

/// Inverse of the standard normal's distribution function (Acklam's rational approximation, 1e-9 relative); -+8 at
/// 0, 1.
double exact_probit(double share);

/// Global cloud cover on the cube sphere: RGBA8, faces on +-X +-Y +-Z of ECEF, looked up by normalize(S p), with mips
/// that average cover. R is the cover of layer 1; G, B and A belong to the layers to come and equal R.
class WeatherMap {
 public:
  static constexpr uint32_t kDefaultSize = 512;  ///< texels along a face: 20 km
  explicit WeatherMap(gpu::Device& device, uint32_t size = kDefaultSize);
  /// Makes the map of these settings; cheap when they have not changed.
  void update(const WeatherSettings& settings);
  ImageRef import_into(FrameGraph& graph) const { return graph.import(image_); }
  const gpu::Image& image() const { return image_; }
  uint32_t size() const { return size_; }
  /// Metres of a texel at a face's centre.
  double texel_m() const;

 private:
  std::vector<uint16_t> make_ranks(uint32_t seed) const;
  gpu::Device& device_;
  uint32_t size_;
  gpu::Image image_;
  WeatherSettings settings_;
  std::vector<uint16_t> ranks_;  ///< of `settings_.seed`, face by face
  bool made_ = false;
};

}  // namespace nepho
