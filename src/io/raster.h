#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"

namespace nepho {

/// What a raster's numbers mean vertically.
enum class VerticalDatum { egm96, ellipsoid };

/// Extent of a raster in degrees on WGS84: outer edges of its pixels, west < east. -181 < west < 180 and east may pass
/// 180: look a longitude up as west + fmod(lon - west + 720, 360). A raster that `wraps` spans exactly 360. Rows
/// centred on a pole reach half a pixel past +-90, so that row r always has its centre at north - (r + 0.5) * (north -
/// south) / height.
struct LonLatBounds {
  double west_deg = -180.0, south_deg = -90.0, east_deg = 180.0, north_deg = 90.0;
};

struct RasterInfo {
  std::string path;     ///< as the user named it, for messages
  uint32_t width = 0;   ///< px, in EPSG:4326 after warping
  uint32_t height = 0;  ///< px
  uint32_t bands = 1;   ///< as delivered: 1 elevation, 4 imagery (RGBA); weather 1 (total cover) or 4 (by channel)
  LonLatBounds bounds;  ///< pixel edges, not centres
  bool wraps = false;   ///< spans 360 degrees: column -1 is column width - 1
  /// Pixels here for one of the source, along each axis: warped pictures are read finer than they are, so that what is
  /// interpolated again between these pixels is still what the source's own pixels give.
  double oversampling = 1.0;
  VerticalDatum vertical = VerticalDatum::egm96;  ///< elevation only
  double opacity = 1.0;                           ///< elevation only: share of its heights where it has data, 0..1
  /// Changes whenever the same place may give other numbers: time and size of the file, settings of RasterReading.
  /// A copy of blocks that outlives the program belongs to path and fingerprint; empty: keep none.
  std::string fingerprint = {};
};

/// Texels of one block, row 0 northernmost. `valid[i]` is 0 where there is no data (nodata value, alpha 0, mask).
struct RasterBlock {
  uint32_t width = 0, height = 0;
  /// width * height * bands, band-interleaved by pixel; imagery 0..255, heights in m, weather 0..1
  std::vector<float> values;
  std::vector<uint8_t> valid;  ///< width * height
};

/// A raster on the EPSG:4326 grid, whatever it was before. Blocks are read at power-of-two reductions, aligned to the
/// raster's own pixels, so that the same place always yields the same numbers whichever block is asked for.
/// Thread-safe.
class Raster {
 public:
  static constexpr uint32_t kBlockSize = 256;  ///< px per side of a block at any reduction
  virtual ~Raster() = default;
  virtual const RasterInfo& info() const = 0;
  /// Number of useful reductions, 0 .. reductions() - 1: at reduction k a pixel averages 2^k x 2^k source pixels (only
  /// the valid ones); at the last the raster fits one block.
  virtual uint32_t reductions() const = 0;
  /// Block (bx, by) of the grid reduced by 2^k: pixels bx*256.. of ceil(width / 2^k). Edge blocks are smaller. Fails
  /// with one line that names the file when it cannot be read or has no such block.
  virtual Result<RasterBlock> read_block(uint32_t reduction, uint32_t bx, uint32_t by) const = 0;
  /// Level of the source's own pyramid that a read at this reduction starts from; 0: its full size, so that the read
  /// looks at every pixel of the source there.
  virtual uint32_t pyramid_level(uint32_t /*reduction*/) const { return 0; }
};

/// How a raster is to be read, where it does not say so itself.
struct RasterReading {
  double opacity = 1.0;  ///< 0..1; of imagery it multiplies alpha, of elevation it is RasterInfo::opacity
  std::optional<VerticalDatum> vertical = {};  ///< elevation; none: from the CRS, else EGM96
  double vertical_scale = 1.0;                 ///< elevation: multiplies heights
  std::string encoding = "auto";               ///< elevation in colours: auto, none, terrarium, mapbox
  bool stretch = true;  ///< imagery that is not 8 bits: percentiles; false: the data type's full range
  std::optional<std::array<double, 2>> black_white = {};  ///< imagery: these numbers become black and white instead
  int min_zoom = 0, max_zoom = -1;                        ///< of tiles; -1: as found, or a usual one
  double timeout_s = 20.0;                                ///< a source on the network that does not answer has failed
};

/// Opens rasters; `rasters` implements it with GDAL, tests with arrays. Only apps know which.
class RasterOpener {
 public:
  virtual ~RasterOpener() = default;
  /// Elevation in metres, one band, raw raster values: RasterInfo::vertical says above what, the caller adds the geoid.
  /// Throws Error(input): missing file, no georeference, unknown CRS, no band.
  virtual std::shared_ptr<Raster> open_elevation(const std::string& path, const RasterReading& how) const = 0;
  std::shared_ptr<Raster> open_elevation(const std::string& path) const { return open_elevation(path, {}); }
  /// Imagery as RGBA, 0..255 sRGB (grey and palettes expanded).
  virtual std::shared_ptr<Raster> open_imagery(const std::string& path, const RasterReading& how) const = 0;
  std::shared_ptr<Raster> open_imagery(const std::string& path) const { return open_imagery(path, {}); }
  /// The rasters that a path is, bottom first. One, but for a folder whose rasters do not make one grid (of several
  /// CRSs or resolutions, or far apart), which open_elevation() and open_imagery() refuse.
  virtual std::vector<std::shared_ptr<Raster>> open_elevation_parts(const std::string& path,
                                                                    const RasterReading& how) const {
    return {open_elevation(path, how)};
  }
  virtual std::vector<std::shared_ptr<Raster>> open_imagery_parts(const std::string& path,
                                                                  const RasterReading& how) const {
    return {open_imagery(path, how)};
  }
  /// Cloud cover 0..1 by the rules of docs/weather.md: one band of total cover (grey pictures, fractions, percent), or
  /// four for the weather channels R, G, B, A (coloured pictures; A is 0 without a fourth band).
  virtual std::shared_ptr<Raster> open_weather(const std::string& path) const = 0;
  /// The same of a picture without a place, to be repeated; its bounds mean nothing.
  virtual std::shared_ptr<Raster> open_tile(const std::string& path) const = 0;
};

}  // namespace nepho
