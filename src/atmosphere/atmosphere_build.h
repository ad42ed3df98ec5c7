#pragma once
#include <string>
#include <utility>
#include <vector>

#include "atmosphere/atmosphere_shared.h"
#include "gpu/device.h"

namespace nepho {

/// Where the tables are computed to (sizes and formats: atmosphere_tables.cpp).
struct AtmosphereTableTargets {
  const gpu::Image& transmittance;
  const gpu::Image& irradiance;
  const gpu::Image& rayleigh;
  const gpu::Image& mie;
  const gpu::Image& multiple;
};

/// Computes the tables for `orders` scattering orders, one submission per step. Returns the steps' GPU times in ms.
std::vector<std::pair<std::string, double>> build_atmosphere_tables(gpu::Device& device,
                                                                    const shared::AtmosphereUniform& air, int orders,
                                                                    const AtmosphereTableTargets& targets);

/// Changes whenever the build does (its shaders, table sizes, version): part of the cache's key.
uint64_t atmosphere_build_hash();

}  // namespace nepho
