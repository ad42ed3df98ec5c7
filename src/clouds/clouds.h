#pragma once
#include <memory>

#include "clouds/cloud_noise.h"
#include "scene/cloud_params.h"
#include "weather/weather_map.h"

namespace nepho {

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

 private:
  CloudParams params_;
  CloudNoise noise_;
  WeatherMap weather_;
};

}  // namespace nepho
