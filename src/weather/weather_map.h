#pragma once
#include <array>
#include <memory>
#include <vector>

#include "geo/geoid.h"
#include "gpu/frame_graph.h"
#include "io/raster.h"
#include "scene/cloud_params.h"

namespace nepho {

/// Rasters that a weather map is made from; opened by the apps.
struct WeatherSources {
  std::shared_ptr<Raster> weather = {};                 ///< RasterOpener::open_weather(), for source raster
  std::shared_ptr<Raster> tile = {};                    ///< RasterOpener::open_tile(), for source tile
  std::vector<std::shared_ptr<Raster>> elevation = {};  ///< as TerrainSources has them, for base_reference terrain
  std::shared_ptr<const Geoid> geoid = {};              ///< may be null: then msl is the ellipsoid
};

/// The global weather on cube spheres, looked up by normalize(S p) with seamless cube samplers (faces and axes are
/// Vulkan's), each with a mip pyramid of means:
/// - coverage, rgba16 unorm: the weather's values 0..1 of channels R, G, B, A; layers make coverage of them
///   (CloudLayer::weather_exponent, coverage_scale). With CloudParams::coverage all are that number.
/// - properties, rgba16f: type (0 stratiform, 0.5 as the layer says, 1 towering), base offset (m), density factor
///   (1: as the layer says), precipitation (0..1).
/// - ground, rg32f: geoid undulation (m) and height of the smoothed ground above the ellipsoid (m; the sea has the
///   geoid's, and where no elevation raster has data it is 0, as the ground is drawn); all 0 unless a layer's
///   base_reference asks for it.
/// - tile, 2D rgba16 with mips, repeating: the local weather texture; 1 x 1 unless the source is tile.
class WeatherMap {
 public:
  /// `procedural_size`: texels along a face of procedural weather, a power of two; 512 is 20 km.
  explicit WeatherMap(gpu::Device& device, uint32_t procedural_size = 512);
  ~WeatherMap();
  /// Makes the maps of these parameters; cheap when nothing that matters here has changed.
  /// Throws Error(input) for a raster that cannot be read or holds nothing, Error(usage) for a source without its file.
  void update(const CloudParams& params, const WeatherSources& sources);
  struct Refs {
    ImageRef coverage, properties, ground, tile;
  };
  Refs import_into(FrameGraph& graph) const;
  /// Metres of a texel of `coverage` at a face's centre; of a very large number for uniform weather.
  double texel_m() const { return texel_m_; }
  /// Range of the height that is added to a layer's base: properties' base offset plus, for that reference, the ground.
  struct OffsetRange {
    double low_m = 0.0, high_m = 0.0;
  };
  OffsetRange base_offset_range(const std::string& base_reference) const;
  /// Images, for tests.
  const gpu::Image& coverage() const { return coverage_; }
  const gpu::Image& properties() const { return properties_; }
  const gpu::Image& ground() const { return ground_; }
  const gpu::Image& tile() const { return tile_; }

 private:
  struct Made;  // what the images were made from
  void make_uniform(double coverage);
  void make_procedural(const WeatherParams& params);
  void make_raster(const Raster& raster, uint32_t channels_used);
  void make_tile(const Raster& raster);
  void make_neutral_properties();
  void make_ground(const WeatherSources& sources, bool wanted);

  gpu::Device& device_;
  uint32_t procedural_size_;
  gpu::Image coverage_, properties_, ground_, tile_;
  double texel_m_ = 1e9;
  OffsetRange base_offset_, geoid_, ground_range_;
  std::unique_ptr<Made> made_;
};

}  // namespace nepho
