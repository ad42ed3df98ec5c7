#pragma once
#include <array>
#include <optional>

#include "clouds/cloud_density.h"
#include "clouds/light_shared.h"
#include "gpu/pipeline.h"

namespace nepho {

/// Extinction and optical depths to the key light on nested maps around the camera (docs/light.md, 'Grid' and 'In
/// sequences'). It lies on the Earth: any camera near the one it was made for reads it alike.
class LightGrid {
 public:
  struct Layout {
    uint32_t texels = 192;        ///< along a side of a level; even
    uint32_t slices = 96;         ///< of its height; even
    float finest_half_m = 4e3f;   ///< half the side of the finest level
    bool all_around = false;      ///< it has what the camera does not see, too: kept when it turns
    uint32_t round_frames = 32u;  ///< in sequences: frames in which it is made anew
  };
  /// `clouds` must outlive it.
  LightGrid(gpu::Device& device, const Clouds& clouds, const Layout& layout);

  struct Refs {
    shared::CloudGrid places;
    ImageRef grid;  ///< rgba16f, 3D: extinction and optical depths (clouds/cloud_grid.glsl)
    ImageRef most;  ///< r16f, 3D: the largest extinction around
  };
  /// The grid for a frame. A still's is made for its camera and clock, or kept while these stay. In a sequence it is
  /// kept while it is nearly right, and made anew a part each frame. `constants`: all but the grid.
  Refs add(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density, bool sequence,
           const shared::CloudLightConstants& constants);
  /// Forgets what is there: parameters have changed.
  void renew();

  /// Nested maps around what a camera sees of the clouds.
  shared::RegionMap region(const FrameInfo& frame) const;

 private:
  /// What a grid was made for.
  struct Key {
    glm::dvec3 camera_ecef_m{0.0};
    double time_s = 0.0;
    glm::vec3 key_dir{0.0f}, forward{0.0f};
    bool all_around = false;
    bool operator==(const Key&) const = default;
  };
  struct Grid {
    gpu::Image extinction, grid, most;
    shared::CloudGrid places{};
    Key key;
    bool filled = false;
  };
  struct Round {  ///< on its way into the other grid
    FrameInfo frame;
    shared::CloudLightConstants constants;
    uint32_t step = 0;
  };
  enum class Fit { good, aged, wrong };
  Key key_of(const FrameInfo& frame, bool all_around) const;
  shared::CloudGrid places(const FrameInfo& frame, bool all_around) const;
  /// How far the grid that is there serves another moment.
  Fit fit(const Grid& grid, const Key& now, const shared::CloudGrid& wanted) const;
  void prepare(Grid& grid, const Key& key, const shared::CloudGrid& places);
  void advance_round(FrameGraph& graph);
  struct Range {
    uint32_t first = 0, end = 0;
  };
  void add_bake(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density, BufferRef data, Grid& grid,
                Range rows);
  void add_most(FrameGraph& graph, BufferRef data, Grid& grid);
  void add_sun(FrameGraph& graph, const FrameInfo& frame, BufferRef data, Grid& grid, Range planes);

  gpu::Device& device_;
  const Clouds& clouds_;
  Layout layout_;
  std::array<gpu::ComputePipeline, 2> bake_;  ///< by phases - 1
  gpu::ComputePipeline sun_;
  std::array<gpu::ComputePipeline, 3> spread_;  ///< by axis
  std::array<Grid, 2> grids_;
  uint32_t front_ = 0;  ///< the one that is read
  std::optional<Round> round_;
  double fastest_mps_ = 0.0;  ///< of the layers' winds
};

}  // namespace nepho
