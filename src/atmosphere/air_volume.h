#pragma once
#include "atmosphere/air_volume_shared.h"
#include "atmosphere/atmosphere_tables.h"
#include "gpu/frame_info.h"

namespace nepho {

/// Aerial perspective and the light at points for one frame, as textures that are small and quick to read
/// (shaders/atmosphere/air_volume.glsl; docs/atmosphere.md, 'Air volume').
/// Reads the atmosphere's tables. Writes a volume of the air before any point that the camera sees, and tables of the
/// light by height.
class AirVolume {
 public:
  /// Of a frame; empty where it has none.
  struct Refs {
    BufferRef data;
    ImageRef volume, tables;
    explicit operator bool() const { return static_cast<bool>(volume); }
  };
  AirVolume(gpu::Device& device, uint32_t spectral_groups);

  /// Whether it is accurate for a camera, with points up to `top_m` of geodetic height: low in the air, as sky views
  /// are, and not at dusk (the sun between 0.6 and 18 degrees below the horizontal), when light falls too fast along a
  /// ray. Elsewhere paths are integrated one by one.
  static bool serves(const shared::AtmosphereUniform& air, const shared::FrameConstants& frame, double top_m);
  /// `top_m`: geodetic height that no lit point exceeds, m.
  Refs add(FrameGraph& graph, const FrameInfo& frame, const AtmosphereTables& tables,
           const AtmosphereTables::Refs& atmosphere, double top_m) const;
  /// For shaders that include air_volume.glsl; without a volume they get something that they must not read.
  static void bind(FrameGraph& graph, FrameGraph::PassBuilder& pass, const Refs& refs,
                   const AtmosphereTables::Refs& atmosphere);

 private:
  gpu::ComputePipeline fill_, tables_;
};

/// What the shaders know of a frame's volume.
shared::AirVolumeData make_air_volume(const shared::AtmosphereUniform& air, const AtmosphereParams& params,
                                      const shared::FrameConstants& frame, double top_m);

}  // namespace nepho
