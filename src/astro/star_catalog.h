#pragma once
#include <filesystem>
#include <vector>

#include "geo/geodetic.h"

namespace nepho {

/// A star of the catalogue.
struct Star {
  dvec3 dir_icrs{1.0, 0.0, 0.0};  ///< unit, mean place at J2000.0 to 8", as the file has it; no proper motion
  double magnitude = 0.0;         ///< V
  vec3 color{1.0f};               ///< linear Rec. 709 of luminance 1, inside the gamut
  int hr = 0;                     ///< number in the Bright Star Catalogue
};

/// Illuminance of a star of magnitude 0 above the air, lux: V = 0 is 2.54e-6 lux (Allen; -14.0 mag to a lux).
inline constexpr double kMagnitudeZero_lux = 2.54e-6;
double star_illuminance_lux(double magnitude);

/// Reads marble's stars/stars.dat (Bright Star Catalogue to V = 5.99, 5,022 stars): big-endian; "star", int32 version
/// 4, then records of 32 bytes {int32 HR, f64 right ascension rad, f64 declination rad, f64 V, int32 colour class}. The
/// class is a bin of B-V, 0 blue .. 6 garnet. Throws Error(input) in one line for a file that is missing, damaged or
/// short.
std::vector<Star> read_star_catalog(const std::filesystem::path& path);

}  // namespace nepho
