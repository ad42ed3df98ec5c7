#pragma once
#include <cstdint>
#include <string>

namespace nepho {

/// Texel formats in use. `_f` is floating point, `_u` unsigned integer, otherwise unsigned normalised.
enum class Format {
  undefined,
  r8,
  rg8,
  rgba8,
  rgba8_srgb,
  r16,
  rg16,
  rgba16,
  rg16_snorm,
  r16f,
  rg16f,
  rgba16f,
  r32f,
  rg32f,
  rgba32f,
  r32u,
  rg32u,
  rgba32u,
  d32f,
};

uint32_t bytes_per_texel(Format format);
const char* name_of(Format format);

struct Extent2D {
  uint32_t width = 1, height = 1;
  bool operator==(const Extent2D&) const = default;
};

struct Extent3D {
  uint32_t width = 1, height = 1, depth = 1;
  Extent3D() = default;
  Extent3D(uint32_t w, uint32_t h, uint32_t d = 1) : width(w), height(h), depth(d) {}
  Extent3D(Extent2D e) : width(e.width), height(e.height) {}
  bool operator==(const Extent3D&) const = default;
};

/// What an image is. depth > 1 makes it a 3D image, layers > 1 a 2D array; `cube` (layers = 6) is sampled as a cube
/// and stored to as a 2D array of six layers.
struct ImageDesc {
  Extent3D extent;
  Format format = Format::rgba16f;
  uint32_t mip_levels = 1;
  uint32_t layers = 1;
  bool cube = false;
  bool operator==(const ImageDesc&) const = default;
};

struct BufferDesc {
  uint64_t size_bytes = 0;
  bool operator==(const BufferDesc&) const = default;
};

/// Filter and addressing of a sampled image. `linear_*` also filters between mips.
enum class Sampler {
  linear_clamp,
  linear_repeat,
  nearest_clamp,
  linear_repeat_u
};  // repeat_u: repeat in u, clamp in v

inline Extent2D half_of(Extent2D e) { return {(e.width + 1) / 2, (e.height + 1) / 2}; }

/// Mip levels of a full pyramid.
inline uint32_t full_mip_levels(Extent3D e) {
  uint32_t largest = e.width > e.height ? e.width : e.height;
  if (e.depth > largest) largest = e.depth;
  uint32_t levels = 1;
  while (largest >>= 1) ++levels;
  return levels;
}

}  // namespace nepho
