#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace nepho {

/// A cubic volume as a file holds it.
struct NoiseVolumeFile {
  uint32_t size = 0;                       ///< texels a side, a power of two, 8..256
  std::vector<std::vector<float>> planes;  ///< one per channel, size^3 values, x fastest
};

/// Reads a noise volume of one channel, or of three (`channels`). By the file's extension:
/// - .bin, .raw: nothing but bytes, N x N x N, x fastest; three channels interleaved as RGB or RGBA.
/// - .png, .exr: N slices of N x N, one below the other (N x N*N) or side by side (N*N x N); the first channel of a
///   volume of one.
/// Throws Error(input), naming the file: missing, no such file format, no cube, N no power of two or not 8..256, too
/// few channels, values that are not finite.
NoiseVolumeFile read_noise_volume(const std::string& file, uint32_t channels);

/// Reads spatiotemporal blue noise, kBlueSlices slices of kBlueSize x kBlueSize, as the same kinds of file with one
/// channel; its ranks within every slice as 0..255. Throws Error(input).
std::vector<uint8_t> read_blue_noise(const std::string& file);

}  // namespace nepho
