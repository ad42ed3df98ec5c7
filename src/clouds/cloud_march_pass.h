#pragma once
#include <array>
#include <memory>

#include "atmosphere/air_volume.h"
#include "clouds/cloud_density.h"
#include "clouds/cloud_light.h"
#include "clouds/cloud_pixel_list.h"
#include "gpu/pipeline.h"

namespace nepho {

/// Marches the cloud layers for every pixel (shaders/clouds/cloud_march.comp, docs/clouds.md), then lights what it
/// found (cloud_shade.comp). Reads the distance to the surface, the atmosphere's tables, the weather maps and the noise
/// volumes. Writes luminance + transmittance and per-pixel facts. With nothing to draw it only clears its outputs.
class CloudMarchPass {
 public:
  struct Inputs {
    ImageRef depth_m;  ///< r32f: distance along the pixel's ray to the surface, m; 1e10 for none
    AtmosphereTables::Refs atmosphere = {};
    AirVolume::Refs air_volume = {};  ///< may be empty: the air before clouds is integrated
    CloudDensityRefs density;         ///< import_cloud_density()
    CloudLight::Refs light;           ///< of this frame
    CloudPixelList list = {};         ///< pixels to be marched; empty: all
    ImageRef radiance = {}, info = {},
             depths = {};  ///< with a list: outputs that hold something at the other pixels already
  };
  struct Outputs {
    /// rgba32f: luminance of the clouds at the camera, cd/m2, premultiplied and with its aerial perspective;
    /// transmittance. The picture is rgb + a * background, where the background has its own aerial perspective.
    ImageRef radiance;
    /// rgba32f: contribution-weighted depth, m (1e10: none); optical depth along the ray, up to about 16;
    /// dominant layer (0 none, 1..4: its place in CloudParams::layers); march steps + 1024 x samples of density.
    ImageRef info;
    /// rgba32f: what `radiance` has at the nearer of two depths, and its opacity; the rest is at the farther one.
    ImageRef near;
    ImageRef depths;  ///< rg32f: the two, m; equal, and `near` nothing, where there is one; 1e10 without clouds
  };
  /// `clouds` must outlive the pass. `spectral_groups`: AtmosphereTables::spectral_groups() of the tables that add()
  /// gets. `fine`: half as long steps, and four rays a pixel where a pixel is wider than clouds' cells.
  CloudMarchPass(gpu::Device& device, const Clouds& clouds, uint32_t spectral_groups, bool fine = false);
  Outputs add(FrameGraph& graph, const FrameInfo& frame, const Inputs& in) const;

  /// The march without the lighting.
  struct Marched {
    ImageRef light;   ///< rgba32f: shares of key light, sky light and ground light, 1/sr; transmittance
    ImageRef info;    ///< as Outputs::info
    ImageRef near;    ///< rgba32f: the part of the shares that is at the nearer of two depths; its opacity
    ImageRef depths;  ///< as Outputs::depths
  };
  /// There must be something to draw.
  Marched add_march(FrameGraph& graph, const FrameInfo& frame, const Inputs& in) const;

 private:
  const gpu::ComputePipeline& march_pipeline(uint32_t phases, bool terrain, bool rays, bool listed) const;
  const gpu::ComputePipeline& shade_pipeline(bool listed, bool volume) const;
  gpu::Device& device_;
  const Clouds& clouds_;
  uint32_t spectral_groups_;
  gpu::ComputePipeline clear_;
  bool fine_;
  /// By phases - 1, with terrain's shade or without (2), with four rays or one (4), over a list (8); made when a frame
  /// needs it.
  mutable std::array<gpu::ComputePipeline, 16> march_;
  mutable std::array<gpu::ComputePipeline, 4> shade_;  ///< over a list (1), with an air volume (2)
};

}  // namespace nepho
