#pragma once
#include <cstdint>
#include <vector>

#include "gpu/device.h"

namespace nepho {

/// A planet's weather out of a seed (docs/weather.md, 'Procedural'). Channels: low, middle, high clouds, deep
/// convection.
struct GeneratedWeather {
  uint32_t size = 0;  ///< texels along a face
  /// Per texel and channel the share of the globe that is less cloudy, 0..65535 for 0..1; 6 * size^2 * 4.
  std::vector<uint16_t> ranks;
  /// Type, base offset (m), density factor, precipitation as half floats; 6 * size^2 * 4.
  std::vector<uint16_t> properties;
};

/// Made on the GPU, and kept in cache_dir().
GeneratedWeather generate_weather(gpu::Device& device, uint32_t size, uint32_t seed);

}  // namespace nepho
