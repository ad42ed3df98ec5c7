#include "astro/star_catalog.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>

#include "astro/spectral_color.h"
#include "base/error.h"

namespace nepho {

namespace {

constexpr size_t kHeaderBytes = 8, kRecordBytes = 32;
constexpr int32_t kVersion = 4;
constexpr const char* kHelp = "reinstall the package marble-qt-data";

/// Mean B-V of the classes, found from stars whose B-V is known (docs/night_sky.md): the bins begin near -0.12, 0.06,
/// 0.45, 1.0, 1.6 and 2.0.
constexpr std::array<double, 7> kClass_BV = {-0.2, -0.04, 0.2, 0.8, 1.2, 1.7, 2.3};

/// The file has stars bluer than B-V -0.11 in class 2 (white), as if their class were unknown. The bright ones, put
/// right: Achernar, Elnath, Bellatrix, Mintaka, Alnilam, Alnitak, Saiph, Mirzam, Adhara, zeta Puppis, gamma Velorum,
/// Acrux, Mimosa, Spica, Alkaid, Hadar, Shaula, Nunki, Peacock.
constexpr std::array<int, 19> kBlueStars = {472,  1790, 1791, 1852, 1903, 1948, 2004, 2294, 2618, 3165,
                                            3207, 4730, 4853, 5056, 5191, 5267, 6527, 7121, 7790};

/// The catalogue has right ascensions to 0.1 s, the file has dropped the tenths: put back what is lost on average.
constexpr double kLostTenths_rad = 0.45 * 15.0 / 3600.0 * std::numbers::pi / 180.0;

uint64_t big_endian(const char* at, size_t bytes) {
  uint64_t value = 0;
  for (size_t i = 0; i < bytes; ++i) value = value << 8 | static_cast<unsigned char>(at[i]);
  return value;
}
int32_t int32_at(const char* at) { return static_cast<int32_t>(static_cast<uint32_t>(big_endian(at, 4))); }
double double_at(const char* at) { return std::bit_cast<double>(big_endian(at, 8)); }

vec3 color_of_class(size_t index) {
  const dvec3 c = glm::max(rec709_from_planck(kelvin_from_b_minus_v(kClass_BV[index])), dvec3(0.02));
  return vec3(c / (0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z));
}

}  // namespace

double star_illuminance_lux(double magnitude) { return kMagnitudeZero_lux * std::pow(10.0, -0.4 * magnitude); }

std::vector<Star> read_star_catalog(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::ifstream file(path, std::ios::binary);
  if (!file) throw fail(ErrorKind::input, "{}: cannot be opened; install the package marble-qt-data", name);
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (bytes.size() < kHeaderBytes || bytes.compare(0, 4, "star") != 0)
    throw fail(ErrorKind::input, "{}: does not begin with 'star', so it is no star catalogue; {}", name, kHelp);
  const int32_t version = int32_at(&bytes[4]);
  if (version != kVersion)
    throw fail(ErrorKind::input, "{}: has version {}, not {}; {}", name, version, kVersion, kHelp);
  if (bytes.size() == kHeaderBytes || (bytes.size() - kHeaderBytes) % kRecordBytes != 0)
    throw fail(ErrorKind::input, "{}: has {} bytes, not {} and some {} per star: it is cut short; {}", name,
               bytes.size(), kHeaderBytes, kRecordBytes, kHelp);

  std::array<vec3, kClass_BV.size()> colors;
  for (size_t i = 0; i < colors.size(); ++i) colors[i] = color_of_class(i);
  std::vector<Star> stars;
  stars.reserve(bytes.size() / kRecordBytes);
  for (size_t at = kHeaderBytes; at < bytes.size(); at += kRecordBytes) {
    const int32_t hr = int32_at(&bytes[at]);
    const double ra = double_at(&bytes[at + 4]), dec = double_at(&bytes[at + 12]),
                 magnitude = double_at(&bytes[at + 20]);
    const int32_t kind = int32_at(&bytes[at + 28]);
    const bool good = ra >= 0.0 && ra <= 2.0 * std::numbers::pi && std::abs(dec) <= 0.5 * std::numbers::pi &&
                      magnitude > -2.0 && magnitude < 30.0 && kind >= 0 && kind < static_cast<int32_t>(colors.size());
    if (!good)
      throw fail(ErrorKind::input,
                 "{}: star {} makes no sense (right ascension {} rad, declination {} rad, magnitude {}, colour {}); {}",
                 name, (at - kHeaderBytes) / kRecordBytes, ra, dec, magnitude, kind, kHelp);
    const bool blue = kind == 2 && std::binary_search(kBlueStars.begin(), kBlueStars.end(), hr);
    const double lon = ra + kLostTenths_rad;
    stars.push_back({.dir_icrs = {std::cos(dec) * std::cos(lon), std::cos(dec) * std::sin(lon), std::sin(dec)},
                     .magnitude = magnitude,
                     .color = colors[blue ? 0 : static_cast<size_t>(kind)],
                     .hr = hr});
  }
  return stars;
}

}  // namespace nepho
