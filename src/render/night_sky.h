#pragma once
#include <memory>
#include <vector>

#include "astro/sky_bodies.h"
#include "astro/star_catalog.h"
#include "gpu/device.h"
#include "gpu/frame_graph.h"
#include "gpu/frame_info.h"
#include "gpu/pipeline.h"
#include "io/raster.h"
#include "render/moon_map.h"
#include "render/night_sky_shared.h"
#include "scene/scene.h"

namespace nepho {

/// What the sky is made of. Both may be empty: an even grey moon, no stars.
struct SkySources {
  std::shared_ptr<Raster> moon_texture;  ///< imagery, 180 W..180 E on the moon, as marble's clementine.jpg
  std::vector<Star> stars;
};

/// Stars, moon and airglow behind and above the air (docs/night_sky.md). Keeps the catalogue and the moon's map on the
/// GPU; shaders use them through shaders/render/night_sky.glsl.
class NightSky {
 public:
  /// Throws Error(input) when the moon's texture cannot be read.
  NightSky(gpu::Device& device, const SkySources& sources);

  struct Refs {
    BufferRef uniform, star_pixels;
    ImageRef moon_map;
  };
  /// Declares what a frame needs: passes "stars.clear" and "stars.splat" where stars may be seen, otherwise none.
  Refs add(FrameGraph& graph, const FrameInfo& frame, const NightSkyParams& params, const SkyBodies& sky) const;
  /// Declares everything that shaders/render/night_sky.glsl binds.
  static void bind(FrameGraph::PassBuilder& pass, const Refs& refs);

  /// Whether anything of the night may be seen: the sun is below -2 degrees at the camera, or the camera above 60 km.
  static bool shows(const shared::FrameConstants& frame);
  /// Stars are drawn where they are asked for, and the sun is below -2 degrees or the camera above 60 km.
  static bool draws_stars(const shared::FrameConstants& frame, const NightSkyParams& params);
  /// The values that shaders get; `star_unit_lux` 0 where no stars are drawn.
  shared::NightSkyUniform uniform(const shared::FrameConstants& frame, const NightSkyParams& params,
                                  const SkyBodies& sky) const;

 private:
  void load_moon(const MoonMap& map);
  void load_stars(const std::vector<Star>& stars);

  gpu::Device& device_;
  gpu::ComputePipeline splat_;
  gpu::Image moon_map_;
  MoonMap moon_coarse_;  ///< for means over the disc
  gpu::Buffer stars_, no_star_pixels_;
  uint32_t star_count_ = 0;
  float units_per_lux_ = 0.0f;
};

/// Mean over the moon's disc, as seen along `moon_dir`, of albedo * shading with the sun in direction `light` (unit,
/// from the moon), or with light = -moon_dir of the albedo alone. Whole phases: the lit part is integrated, however
/// thin.
double mean_over_moon_disc(const MoonMap& map, const dmat3& moon_from_ecef, const dvec3& moon_dir, const dvec3& light,
                           double lunar_lambert);

}  // namespace nepho
