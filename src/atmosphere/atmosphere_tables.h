#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "atmosphere/atmosphere_shared.h"
#include "gpu/device.h"
#include "gpu/frame_graph.h"
#include "gpu/frame_info.h"
#include "scene/atmosphere_params.h"

namespace nepho {

/// The atmosphere's look-up tables on the GPU (docs/atmosphere.md): optical depth to the top, irradiance, single
/// scattering by gas and by aerosol, multiple scattering with its source function. Constant for given parameters.
class AtmosphereTables {
 public:
  /// Loads the tables from the disk cache (base/files.h, cache_dir()) or computes and caches them.
  /// Throws Error(usage) when a parameter makes no sense.
  AtmosphereTables(gpu::Device& device, const AtmosphereParams& params);

  struct Refs {
    ImageRef transmittance, irradiance, rayleigh, mie, multiple;
    BufferRef params;
  };
  Refs import(FrameGraph& graph, const FrameInfo& frame) const;
  /// Declares everything that shaders/atmosphere/atmosphere_lookup.glsl binds.
  static void bind(FrameGraph::PassBuilder& pass, const Refs& refs);

  const AtmosphereParams& params() const { return params_; }
  const shared::AtmosphereUniform& uniform() const { return uniform_; }
  bool came_from_cache() const { return came_from_cache_; }
  double build_ms() const { return build_ms_; }  ///< wall time of loading or building
  /// GPU time of each step of a build, ms; empty when loaded.
  const std::vector<std::pair<std::string, double>>& step_ms() const { return step_ms_; }
  /// The file that holds these tables; empty without a cache folder.
  const std::filesystem::path& cache_file() const { return cache_file_; }

 private:
  std::array<const gpu::Image*, 5> images() const {
    return {&transmittance_, &irradiance_, &rayleigh_, &mie_, &multiple_};
  }
  bool load(gpu::Device& device, uint64_t key);
  void save(gpu::Device& device, uint64_t key) const;

  AtmosphereParams params_;
  shared::AtmosphereUniform uniform_;
  gpu::Image transmittance_, irradiance_, rayleigh_, mie_, multiple_;
  bool came_from_cache_ = false;
  double build_ms_ = 0.0;
  std::vector<std::pair<std::string, double>> step_ms_;
  std::filesystem::path cache_file_;
};

}  // namespace nepho
