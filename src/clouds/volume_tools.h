#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace nepho {

/// Inverse of the standard normal distribution function, 0 < share < 1; relative error 1e-15 (Wichura 1988, AS 241).
double probit(double share);

/// Values brought to mean 0 and variance 1; `gaussian` first gives them a normal distribution by rank (Heitz and Neyret
/// 2018), equal values sharing their mean rank. False, and values untouched, when they are all the same.
bool normalise_volume(std::vector<float>& values, bool gaussian);

/// Takes out of every plane what it has in common with those before it: noise of few cycles is alike by chance.
void decorrelate(std::vector<std::vector<float>>& planes);

/// The next mip of a cubic volume of `size` texels a side (x fastest): means of 2 x 2 x 2.
std::vector<float> half_volume(const std::vector<float>& values, uint32_t size);

/// Curl of a periodic vector potential by central differences, so that central differences of the result have no
/// divergence. The potential's components are scaled until every one of the curl's has variance 1.
std::array<std::vector<float>, 3> curl_of(const std::array<std::vector<float>, 3>& potential, uint32_t size);

/// A cubic volume as texels with all its mips, and what they keep of the variance.
struct MippedVolume {
  uint32_t size = 0;              ///< texels a side, a power of two
  std::vector<std::byte> texels;  ///< mip after mip, channels interleaved; -kRange..kRange as 0..1
  /// What a mip keeps of mip 0's variance, both as they are read: linearly between texels, anywhere.
  /// [mip * channels + channel]
  std::vector<float> variances;
  static constexpr float kRange = 4.0f;  ///< standard deviations
};

/// Mips of planes (one per channel) of size^3 values each; 1 or 2 bytes a channel.
MippedVolume make_mips(std::vector<std::vector<float>> planes, uint32_t size, uint32_t bytes_per_channel);

/// Mean square of a periodic volume as it is read, linearly between texels: less than that of its texels.
double mean_square_between(const std::vector<float>& values, uint32_t size);

/// Bytes of all mips, of a volume of `size` texels a side.
size_t bytes_of_mips(uint32_t size, uint32_t bytes_per_texel);

}  // namespace nepho
