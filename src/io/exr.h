#pragma once
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <map>
#include <optional>
#include <string>

#include "io/image_buffer.h"

namespace nepho {

/// Header attributes of an EXR. The first group are OpenEXR's standard ones, with their units; absent where not set.
struct ExrAttributes {
  std::optional<float> longitude_deg;        ///< `longitude`: of the camera, degrees east of Greenwich
  std::optional<float> latitude_deg;         ///< `latitude`: degrees north of the equator
  std::optional<float> altitude_m;           ///< `altitude`: metres above mean sea level
  std::optional<std::string> cap_date;       ///< `capDate`: scene time, "YYYY:MM:DD hh:mm:ss", UTC; see exr_cap_date()
  std::optional<float> utc_offset_s;         ///< `utcOffset`: UTC minus local time, s; 0 as capDate is UTC
  std::optional<glm::mat4> world_to_camera;  ///< `worldToCamera`: column vectors as everywhere here; stored transposed,
  std::optional<glm::mat4> world_to_ndc;     ///< `worldToNDC`:    as OpenEXR multiplies row vectors from the left
  std::optional<float> white_luminance;      ///< `whiteLuminance`: cd/m2 of RGB (1,1,1); 1 when R G B are in cd/m2
  std::optional<std::string> comments;       ///< `comments`
  bool rec709 = true;                        ///< `chromaticities` of Rec. 709 (an EXR without them means the same)
  std::map<std::string, std::string> strings;  ///< further attributes by name, such as "nepho:scene"
  std::map<std::string, float> floats;         ///< such as "nepho:fov"
  bool operator==(const ExrAttributes&) const = default;
};

/// What an EXR file holds.
struct ExrFile {
  ImageBuffer image;
  ExrAttributes attributes;
};

/// ISO 8601 UTC ("2026-06-20T23:30:00Z", fractions of a second dropped) as capDate wants it ("2026:06:20 23:30:00").
std::string exr_cap_date(const std::string& iso8601_utc);

/// Writes every channel as 32-bit float scan lines, ZIP compressed; a name "layer.part" makes a layer. Whole or not at
/// all; equal input gives equal bytes, whatever the number of threads. Throws Error(failure) with the path.
void write_exr(const std::filesystem::path& path, const ImageBuffer& image, const ExrAttributes& attributes);

/// Reads any flat EXR (first part, scan lines or tiles, half, float or uint), channels in the file's order (by name).
/// Throws Error(input) with the path: missing, not an EXR, cut off, deep, or with subsampled channels.
ExrFile read_exr(const std::filesystem::path& path);

}  // namespace nepho
