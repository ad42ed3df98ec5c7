#pragma once
#include <string>

namespace nepho {

/// Which numbers of a picture become black and white.
struct Stretch {
  /// automatic: 8-bit numbers as they are, others from the 1st to the 99th percentile of a sample (docs/data.md).
  /// none: the full range of the data type, 0..1 of floating point. range: from low to high.
  enum class Kind { automatic, none, range };
  Kind kind = Kind::automatic;
  double low = 0.0, high = 1.0;  ///< of `range`, low < high
  bool operator==(const Stretch&) const = default;
};

/// One elevation raster of the stack: any name that GDAL opens, a folder of rasters, or a folder or URL of tiles
/// ("https://.../{z}/{x}/{y}.png"); docs/data.md.
struct ElevationSource {
  std::string path;
  double order = 0.0;                   ///< lower ones lie below; among equals the place in the list decides
  double opacity = 1.0;                 ///< share of its heights in the result where it has data, 0..1
  std::string vertical_datum = "auto";  ///< auto (the CRS, else egm96), ellipsoid, egm96
  double vertical_scale = 1.0;          ///< multiplies its heights; negative for depths that count downwards
  std::string encoding = "auto";        ///< heights in colours: auto, none, terrarium, mapbox
  int min_zoom = 0;                     ///< of tiles: coarsest zoom there is
  int max_zoom = -1;                    ///< of tiles: finest zoom; -1: the finest found in a folder, 15 of a URL
  bool operator==(const ElevationSource&) const = default;
};

/// One picture of the ground of the stack: as above.
struct ImagerySource {
  std::string path;
  double order = 0.0;         ///< as above
  double opacity = 1.0;       ///< multiplies its alpha, 0..1
  double gamma = 1.0;         ///< brightness = number^(1/gamma): above 1 lightens the middle tones, > 0
  double albedo_scale = 1.0;  ///< multiplies the albedo (the linear value of the sRGB colour), >= 0
  Stretch stretch = {};
  int min_zoom = 0;   ///< as above
  int max_zoom = -1;  ///< as above; 19 of a URL
  bool operator==(const ImagerySource&) const = default;
};

}  // namespace nepho
