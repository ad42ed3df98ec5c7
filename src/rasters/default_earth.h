#pragma once
#include <string>

namespace nepho {

/// Files of the default Earth, as RasterOpener takes them; empty where the Debian package is not installed.
struct DefaultEarth {
  std::string elevation;  ///< ferret-datasets: ETOPO5, 5 arcmin heights and depths above mean sea level, m
  std::string imagery;    ///< marble-qt-data: Blue Marble, 2700 x 1350, global
  std::string night;      ///< xplanet-images: city lights on black, 2048 x 1024, global
  std::string moon;       ///< marble-qt-data: Clementine's mosaic of the moon, 2700 x 1350
  std::string stars;      ///< marble-qt-data: Bright Star Catalogue; for read_star_catalog(), not a raster
};

/// Looks in /usr/local/share and /usr/share; touches the disk only.
DefaultEarth find_default_earth();

/// True for a file of the default Earth. The program knows that these are global, so opening one gives no warning.
bool is_default_earth_file(const std::string& path);

}  // namespace nepho
