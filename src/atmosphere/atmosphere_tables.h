#pragma once
#include <array>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "atmosphere/atmosphere_uniform.h"
#include "gpu/device.h"
#include "gpu/frame_graph.h"
#include "gpu/pipeline.h"
#include "scene/atmosphere_params.h"

namespace nepho {

class AtmosphereBuild;

/// The atmosphere's look-up tables on the GPU (docs/atmosphere.md): columns of matter to the top, irradiance, the
/// source function of multiple scattering, the sky that water mirrors. Constant for given parameters.
class AtmosphereTables {
 public:
  enum class Start {
    at_once,  ///< the constructor loads or computes everything
    sliced,   ///< the constructor loads, or leaves the computing to advance()
  };
  /// Loads the tables from the disk cache (base/files.h, cache_dir()) or computes and caches them.
  /// Throws Error(usage) when a parameter makes no sense.
  AtmosphereTables(gpu::Device& device, const AtmosphereParams& params, Start start = Start::at_once);
  ~AtmosphereTables();

  /// Computes for about `budget_ms`, one short step at least. True when the tables are ready, which they must be before
  /// add() is called. Frames may use other tables between the calls.
  bool advance(double budget_ms);
  bool ready() const { return !build_; }
  double progress() const;  ///< share of the steps that are done, 0..1

  struct Refs {
    ImageRef transmittance, irradiance, source, mirror, sky_view;
    BufferRef params, sky_views;
  };
  /// Brings the tables into a frame and integrates its sky views (make_sky_view), one per light; none for a camera too
  /// high for one (has_sky_view).
  Refs add(FrameGraph& graph, std::span<const shared::SkyView> views) const;
  /// Declares everything that shaders/atmosphere/atmosphere_lookup.glsl binds.
  enum class Views { of_a_frame, many };  ///< many: for shaders with ATMOSPHERE_MANY_VIEWS
  static void bind(FrameGraph::PassBuilder& pass, const Refs& refs, Views views = Views::of_a_frame);
  /// Specialisation constant 0 of every shader that includes it.
  uint32_t spectral_groups() const { return static_cast<uint32_t>(constants_.spectral_groups); }

  const AtmosphereParams& params() const { return params_; }
  const shared::AtmosphereUniform& uniform() const { return constants_.data.air; }
  bool came_from_cache() const { return came_from_cache_; }
  double build_ms() const { return build_ms_; }  ///< wall time of loading or building
  /// GPU time of each pass of a build, ms; empty when loaded.
  const std::vector<std::pair<std::string, double>>& step_ms() const { return step_ms_; }
  /// The cache's name for these tables.
  std::string cache_name() const;

 private:
  std::array<const gpu::Image*, 4> images() const { return {&transmittance_, &irradiance_, &source_, &mirror_}; }
  bool load();
  void save() const;

  gpu::Device& device_;
  AtmosphereParams params_;
  AtmosphereConstants constants_;
  uint64_t key_ = 0;
  gpu::Image transmittance_, irradiance_, source_, mirror_;
  gpu::ComputePipeline sky_view_;
  std::unique_ptr<AtmosphereBuild> build_;
  bool came_from_cache_ = false;
  double build_ms_ = 0.0;
  std::vector<std::pair<std::string, double>> step_ms_;
};

}  // namespace nepho
