#pragma once
#include <array>
#include <optional>
#include <vector>

#include "clouds/cloud_anchor.h"
#include "clouds/cloud_noise.h"
#include "clouds/clouds_shared.h"
#include "scene/cloud_params.h"
#include "weather/weather_map.h"

namespace nepho {

/// Of what lies below clouds, for light from under them.
inline constexpr float kGroundAlbedo = 0.15f;

/// True when these parameters draw nothing: coverage 0, or no layer with thickness and extinction.
bool draws_nothing(const CloudParams& params);

/// The layers that draw something, as indices of CloudParams::layers.
std::vector<uint32_t> drawing_layers(const CloudParams& params);

/// Shortest useful step of a march through a layer, m: half a small billow, or a tenth of an optical depth where that
/// is longer.
double march_step_m(double cell_size_m, double extinction_per_m);

/// What draws clouds besides a frame's own data: parameters, noise, weather, and the thresholds that make coverage a
/// quantity. Everything that looks at clouds (march, shadows, probes) takes it.
class Clouds {
 public:
  /// Makes noise and maps (or reads them from cache_dir()) and calibrates the layers. Throws Error(input) for files
  /// that are no weather or noise.
  Clouds(gpu::Device& device, const CloudParams& params, const WeatherSources& sources = {});
  const CloudParams& params() const { return params_; }
  const CloudNoise& noise() const { return noise_; }
  const WeatherMap& weather() const { return weather_; }
  /// The uniform block without its anchor, which a frame or a probe fills.
  const shared::CloudConstants& constants() const { return constants_; }

  struct HeightRange {
    double low_m = 0.0, high_m = 0.0;
  };
  /// Geodetic heights between which each drawn layer is, wherever its base follows ground or weather; as constants()
  /// orders them.
  const std::vector<HeightRange>& layer_ranges() const { return layer_ranges_; }

  /// Values of the specialisation constants 0..4 for shaders that include clouds/cloud_density.glsl; 0 is left free, 5
  /// is the march's own. `phases`: phases_at() of the moment, or 2 for any moment.
  std::vector<uint32_t> specialisation(uint32_t phases) const;
  /// Patterns that overlap at a moment, 1 or 2.
  uint32_t phases_at(double time_s) const;
  /// The part of the uniform block that camera and clock decide.
  shared::CloudAnchor anchor(const glm::dvec3& camera_ecef_m, double time_s) const {
    return make_cloud_anchor(lattices_, params_, camera_ecef_m, time_s);
  }

 private:
  /// Fills the layers' thresholds, from the disk cache where they are.
  void calibrate(gpu::Device& device);
  std::optional<uint64_t> calibration_key() const;  ///< nothing: not to be cached
  /// False when some layer is too thin to count as covered; that is warned of each time.
  bool measure_thresholds(gpu::Device& device);
  CloudParams params_;
  CloudNoise noise_;
  WeatherMap weather_;
  CloudLattices lattices_;
  shared::CloudConstants constants_{};
  std::vector<HeightRange> layer_ranges_;
};

}  // namespace nepho
