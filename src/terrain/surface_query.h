#pragma once
#include <cstdint>
#include <string>

#include "geo/geodetic.h"
#include "terrain/height_sampler.h"

namespace nepho {

/// The drawn ground at a place.
struct SurfacePoint {
  double height_m = 0.0;      ///< above the ellipsoid
  double height_msl_m = 0.0;  ///< above the geoid (EGM96); above the ellipsoid without one
  double slope_rad = 0.0;     ///< between the triangle there and the ellipsoid's horizontal
  bool sea = false;           ///< the height is the geoid's
  /// File name of the raster that decides the height: the one with the largest share in it, the upper one of two equal
  /// ones; on the sea the raster whose height there is at or below 0. Where several rasters of the stack have one file
  /// name, the whole path. "ellipsoid" where no raster has data.
  std::string source;
};

/// The finest level at which a place is ever drawn: 18, less around the poles.
uint32_t finest_level_at(double lat_deg, double lon_deg);

/// The surface as a close camera sees it: the triangle of the finest level's mesh, its vertices in ECEF, its diagonals
/// from north-east to south-west, where the ellipsoid's normal pierces it. A camera further off is shown a coarser
/// mesh, as far off as a pixel's share (TerrainParams::screen_error_px). Thread-safe. `lat_rad` -pi/2..pi/2, any
/// longitude.
SurfacePoint surface_at(const HeightSampler& ground, double lat_rad, double lon_rad,
                        const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

/// The height alone, m above the ellipsoid.
double surface_height_m(const HeightSampler& ground, double lat_rad, double lon_rad,
                        const Ellipsoid& ellipsoid = Ellipsoid::wgs84());

/// What a raster is called in results: its path's last part; of GDAL's subdatasets (NETCDF:"/a/b.nc":v) that of the
/// file in them. Templates with {} and connection strings stay whole.
std::string source_file_name(const std::string& path);

}  // namespace nepho
