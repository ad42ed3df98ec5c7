#pragma once
#include <array>
#include <optional>
#include <string>

#include "atmosphere/atmosphere_tables.h"
#include "clouds/cloud_density.h"
#include "clouds/light_grid.h"
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
    bool all_around = false;     ///< LightGrid::Layout
    uint32_t most_paths = 64;    ///< in sequences: that a cell's light is the mean of, at most (two sets at least)
    uint32_t refresh_frames = 4;  ///< in sequences: in which each cell that has light gets a path more
    float deepest = 30.0f;        ///< optical depth of the grid beyond which no cell is seen
    uint32_t round_frames = 32;   ///< LightGrid::Layout
  };
  /// Of a preset: medium, high, ultra.
  static Quality quality_of(const std::string& preset);
  /// Of a preset for pictures that come as fast as they can: fewer, larger cells, which get their paths over more
  /// frames. `software`: for a device that is a CPU.
  static Quality live_quality_of(const std::string& preset, bool software);

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
    bool sequence = false;  ///< the picture follows the last one: light and grid may be its, where they still hold
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
  /// Fills grid and cells for a frame: a still's anew (the grid is kept while camera place, light and clock stay), a
  /// sequence's from the last one's (docs/light.md, 'In sequences').
  Refs add(FrameGraph& graph, const FrameInfo& frame, const Inputs& in);

  /// Tells that what add() was given before has changed: other parameters, which may differ from the clouds' own.
  void renew(const CloudParams& params);

  /// Nested maps around what a camera sees of the clouds, for grid and ground.
  shared::RegionMap region(const FrameInfo& frame) const { return grid_.region(frame); }

  /// What the last frame that add() declared traced; after it ran. For tests and benchmarks: waits for the GPU.
  struct Work {
    uint32_t cells = 0;                             ///< seen
    uint32_t fresh = 0, refresh = 0;                ///< of them, traced in full, and with one path more
    uint32_t ground_fresh = 0, ground_refresh = 0;  ///< of the nodes on the ground
    bool cut = true;                                ///< all were traced in full
  };
  Work work();

 private:
  /// Cells before they are smoothed, and what they are of.
  struct Traced {
    gpu::Image cells, ground, ground_weight;
  };
  struct Before {
    FrameInfo frame;
    shared::LightCells cells;
  };
  /// What the cells of this frame may take over from the last one's; sets keep to 0 where nothing.
  void set_history(shared::CloudLightConstants& constants, const FrameInfo& frame, bool sequence) const;
  ImageRef add_sky(FrameGraph& graph, const FrameInfo& frame, const AtmosphereTables::Refs& atmosphere,
                   const shared::RegionMap& map);
  const gpu::ComputePipeline& gather(bool terrain, bool sequence, bool surface);
  gpu::Device& device_;
  const Clouds& clouds_;
  Quality quality_;
  LightGrid grid_;
  gpu::ComputePipeline clear_, mark_, list_, smooth_, smooth_ground_, sky_, history_, ground_history_, args_;
  std::array<gpu::ComputePipeline, 8> gather_;  ///< made when a frame needs them
  gpu::Image beam_, no_albedo_, no_height_, none_, even_sky_;
  gpu::Buffer work_;
  std::array<Traced, 2> traced_images_;
  uint32_t now_ = 0;              ///< the one that this frame fills
  std::optional<Before> before_;  ///< of the other one
  double fastest_mps_ = 0.0;      ///< of the layers' winds
  bool cut_ = true;
  float forward_share_ = 0.0f, wide_g_ = 0.0f, albedo_ = 1.0f, first_m_ = 0.0f;
  bool traced_ = true;  ///< false: octaves
};

}  // namespace nepho
