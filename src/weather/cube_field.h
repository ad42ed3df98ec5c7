#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "geo/cube_sphere.h"
#include "gpu/device.h"

namespace nepho {

/// Unit direction (scaled axes) of a texel's centre on a face of `size` texels a side.
dvec3 cube_texel_direction(uint32_t size, uint32_t face, uint32_t x, uint32_t y);

/// Solid angles of a face's texels, row by row; the same on every face.
std::vector<float> cube_texel_weights(uint32_t size);

/// Geodetic latitude and longitude, degrees, of the point of the ellipsoid whose scaled direction is `dir`.
struct LatLonDeg {
  double lat_deg = 0.0, lon_deg = 0.0;
};
LatLonDeg lat_lon_from_scaled(const dvec3& dir);

/// Bytes of texels in one of the formats rgba8, rgba16 (values 0..1), rgba16f, rg32f, from interleaved floats.
std::vector<std::byte> packed_texels(Format format, std::span<const float> values);

/// A cube image with a full pyramid of means, weighted with the texels' solid angles, so that the mean of the six last
/// texels is the mean over the sphere. `face_texels` gives the interleaved values of a face; one face is in memory at a
/// time. A mip's texels never reach over an edge: the sampler filters across it, from both sides the same.
gpu::Image make_cube_image(gpu::Device& device, const std::string& name, Format format, uint32_t size,
                           const std::function<std::vector<float>(uint32_t face)>& face_texels);

/// A 2D image with a full pyramid of means; sizes need not be powers of two (the mips are those of Vulkan, floor(n/2),
/// each texel the mean of all that it covers).
gpu::Image make_tile_image(gpu::Device& device, const std::string& name, Format format, uint32_t width, uint32_t height,
                           std::vector<float> texels);

}  // namespace nepho
