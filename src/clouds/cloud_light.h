#pragma once
#include <array>
#include <string>

#include "atmosphere/atmosphere_tables.h"
#include "clouds/cloud_density.h"
#include "clouds/light_shared.h"
#include "gpu/pipeline.h"

namespace nepho {

/// The light inside clouds (docs/light.md): a grid of extinction and of optical depth to the key light around the
/// camera, and cells fanning out from it that hold the light scattered more than once, traced backwards from each cell
/// that is seen.
class CloudLight {
 public:
  /// What accuracy costs (docs/light.md has both).
  struct Quality {
    uint32_t paths = 16;         ///< through each cell
    uint32_t node_px = 2;        ///< pixels between nodes, at least
    uint32_t most_nodes = 128;   ///< along the longer side of the picture
    uint32_t grid_texels = 192;  ///< along a side of a level of the grid; even
    uint32_t grid_slices = 96;   ///< of its height; even
    float finest_half_m = 4e3f;  ///< of the grid's finest level: half its side
    uint32_t slices = 384;       ///< of cells along a ray, a multiple of 32
    float first_m = 25.0f;       ///< length of the first of them, at most
    float first_paths = 0.0f;    ///< 0, or its length in free paths of the densest cloud, at most
    float smooth_m = 70.0f;      ///< cells share paths within this,
    float smooth_paths = 0.5f;   ///< and within so many free paths of the scaled medium,
    uint32_t smooth_passes = 1;  ///< by means of 27 of them so many times
    bool all_around = false;     ///< the grid has what the camera does not see, too: kept when it turns
  };
  /// Of a preset: medium, high, ultra.
  static Quality quality_of(const std::string& preset);

  /// `clouds` must outlive it.
  /// `spectral_groups`: AtmosphereTables::spectral_groups() of the tables that add() gets.
  CloudLight(gpu::Device& device, const Clouds& clouds, uint32_t spectral_groups, const Quality& quality);

  struct Inputs {
    ImageRef depth_m;  ///< r32f: distance along the pixel's ray to the surface, m
    CloudDensityRefs density;
    const AtmosphereTables::Refs* atmosphere = nullptr;  ///< without: an even sky
    ImageRef terrain_shadow = {};  ///< with terrain_map as terrain/terrain_volume.glsl reads them; without: no terrain
    BufferRef terrain_map = {};
    shared::RegionMap ground{};  ///< of the two images below
    ImageRef ground_albedo = {},
             ground_height = {};  ///< as terrain/ground_map.glsl reads them; without: a black ellipsoid
  };
  struct Refs {
    BufferRef data;  ///< shared::CloudLightConstants
    ImageRef grid;   ///< rgba16f, 3D: extinction and optical depths to the key light (clouds/cloud_grid.glsl)
    ImageRef most;   ///< r16f, 3D: the largest extinction around
    ImageRef cells;  ///< rgba16f, 3D: shares of key light, sky light and lit ground, 1/sr, times validity; validity
    ImageRef
        ground;  ///< rgba32f, a texel per node: illuminance of the ground by light that clouds scattered, as shares of
                 ///< key light, sky light and key light on the ground; distance of the ground, m. Empty: octaves
    glm::uvec2 nodes{0};
    ImageRef terrain_shadow;  ///< of Inputs, or something to bind
    BufferRef terrain_map;
    bool terrain = false;  ///< of Inputs
    ImageRef beam;         ///< rgba32f: shared::kBeamTexels wide (clouds/beam_table.h)
  };
  /// Fills grid and cells for a frame. The grid is kept while camera place, light and clock stay.
  Refs add(FrameGraph& graph, const FrameInfo& frame, const Inputs& in);

  /// Tells that what add() was given before has changed: other parameters, which may differ from the clouds' own.
  void renew(const CloudParams& params);

  /// Nested maps around what a camera sees of the clouds, for grid and ground.
  shared::RegionMap region(const FrameInfo& frame) const;

 private:
  struct Key {
    glm::dvec3 camera_ecef_m{0.0};
    double time_s = 0.0;
    glm::vec3 key_dir{0.0f}, forward{0.0f};
    bool operator==(const Key&) const = default;
  };
  void add_grid(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density, BufferRef data,
                const shared::CloudGrid& places);
  gpu::Device& device_;
  const Clouds& clouds_;
  Quality quality_;
  std::array<gpu::ComputePipeline, 2> bake_;  ///< by phases - 1
  gpu::ComputePipeline sun_;
  std::array<gpu::ComputePipeline, 3> spread_;  ///< by axis
  gpu::ComputePipeline mark_, list_, gather_, gather_ground_, smooth_, smooth_ground_, sky_;
  std::array<gpu::ComputePipeline, 2> gather_terrain_;  ///< the two among terrain, made when a frame needs them
  gpu::Image extinction_, grid_, most_, beam_, no_albedo_, no_height_, none_, even_sky_;
  float forward_share_ = 0.0f, wide_g_ = 0.0f, albedo_ = 1.0f, first_m_ = 0.0f;
  bool traced_ = true;  ///< false: octaves
  bool filled_ = false;
  Key key_;
};

}  // namespace nepho
