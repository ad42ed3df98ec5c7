#pragma once
#include <cstdint>
#include <vector>

namespace nepho {

/// Size of spatiotemporal blue noise: kBlueSize x kBlueSize pixels, kBlueSlices frames.
inline constexpr uint32_t kBlueSize = 64, kBlueSlices = 16;

/// Spatiotemporal blue noise (Wolfe et al. 2022) by void and cluster (Ulichney 1993): every slice is blue noise in the
/// plane, and the values of a pixel from slice to slice are blue noise in time, both around the edges. x fastest, then
/// y, then slices; every slice holds each of 0..255 equally often. The same on every machine; takes some 0.2 s.
std::vector<uint8_t> make_blue_noise();

/// Ranks within every slice as 0..255: each of them equally often where no values are equal; equal ones stay so. False
/// when a slice holds one value only.
bool equalise_slices(const std::vector<float>& values, std::vector<uint8_t>& equalised);

}  // namespace nepho
