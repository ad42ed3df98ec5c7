#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "atmosphere/atmosphere_uniform.h"
#include "gpu/device.h"

namespace nepho {

/// Where the tables are computed to (sizes and formats: atmosphere_tables.cpp).
struct AtmosphereTableTargets {
  const gpu::Image& transmittance;
  const gpu::Image& irradiance;
  const gpu::Image& source;
  const gpu::Image& mirror;
};

/// Computes the tables in short steps, so that frames can go on between them. The targets must outlive it and not be
/// used before the last step.
class AtmosphereBuild {
 public:
  AtmosphereBuild(gpu::Device& device, const AtmosphereConstants& air, int orders, const AtmosphereTableTargets& to);
  ~AtmosphereBuild();
  /// Runs the next step and waits for it. False when there was none left.
  bool step();
  int steps_done() const { return next_; }
  int steps() const { return static_cast<int>(todo_.size()); }
  /// GPU time of each pass so far, ms.
  const std::vector<std::pair<std::string, double>>& times() const;

 private:
  class Steps;
  std::unique_ptr<Steps> passes_;
  std::vector<std::function<void()>> todo_;
  int next_ = 0;
};

/// Changes whenever the build does (its shaders, table sizes, version): part of the cache's key.
uint64_t atmosphere_build_hash();

}  // namespace nepho
