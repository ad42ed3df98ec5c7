#include "weather/cube_field.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/packing.hpp>

#include "base/error.h"

namespace nepho {

namespace {

uint32_t channels_of(Format format) {
  switch (format) {
    case Format::rg32f:
      return 2;
    case Format::rgba8:
    case Format::rgba16:
    case Format::rgba16f:
      return 4;
    default:
      NEPHO_ASSERT(!"format of a weather image");
      return 0;
  }
}

/// Half the size: means of 2 x 2 texels by weight. The weights are halved on the way.
void halve_face(std::vector<float>& values, std::vector<float>& weights, uint32_t n, uint32_t channels) {
  const uint32_t half = n / 2;
  std::vector<float> out(size_t{half} * half * channels), out_weights(size_t{half} * half);
  for (uint32_t y = 0; y < half; ++y)
    for (uint32_t x = 0; x < half; ++x) {
      const size_t to = size_t{y} * half + x;
      const size_t from[] = {size_t{2} * y * n + 2 * x, size_t{2} * y * n + 2 * x + 1, (size_t{2} * y + 1) * n + 2 * x,
                             (size_t{2} * y + 1) * n + 2 * x + 1};
      float weight = 0.0f;
      for (const size_t i : from) weight += weights[i];
      out_weights[to] = weight;
      for (uint32_t c = 0; c < channels; ++c) {
        float sum = 0.0f;
        for (const size_t i : from) sum += weights[i] * values[i * channels + c];
        out[to * channels + c] = sum / weight;
      }
    }
  values = std::move(out);
  weights = std::move(out_weights);
}

/// Means over the source texels of each of `to` equal parts of a line of `from` texels.
std::vector<float> resized_rows(const std::vector<float>& values, uint32_t from, uint32_t to, uint32_t stride,
                                uint32_t lines, uint32_t line_stride, uint32_t channels) {
  std::vector<float> out(size_t{to} * lines * channels, 0.0f);
  const double step = static_cast<double>(from) / to;
  for (uint32_t i = 0; i < to; ++i) {
    const double a = i * step, b = (i + 1) * step;
    for (auto k = static_cast<uint32_t>(a); k < from && k < b; ++k) {
      const auto share = static_cast<float>((std::min(b, k + 1.0) - std::max(a, static_cast<double>(k))) / step);
      for (uint32_t line = 0; line < lines; ++line)
        for (uint32_t c = 0; c < channels; ++c)
          out[(size_t{line} * to + i) * channels + c] +=
              share * values[(size_t{line} * line_stride + size_t{k} * stride) * channels + c];
    }
  }
  return out;
}

}  // namespace

dvec3 cube_texel_direction(uint32_t size, uint32_t face, uint32_t x, uint32_t y) {
  return direction_from_cube(face, {(x + 0.5) / size, (y + 0.5) / size});
}

std::vector<float> cube_texel_weights(uint32_t size) {
  std::vector<float> weights(size_t{size} * size);
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x)
      weights[size_t{y} * size + x] = static_cast<float>(
          cube_solid_angle({double(x) / size, double(y) / size}, {double(x + 1) / size, double(y + 1) / size}));
  return weights;
}

LatLonDeg lat_lon_from_scaled(const dvec3& dir) {
  // The geodetic normal is S q: the normal of the sphere, stretched once more along the axis.
  const double z = dir.z / (1.0 - Ellipsoid{}.flattening());
  return {deg_from_rad(std::atan2(z, std::hypot(dir.x, dir.y))), deg_from_rad(std::atan2(dir.y, dir.x))};
}

std::vector<std::byte> packed_texels(Format format, std::span<const float> values) {
  std::vector<std::byte> bytes(values.size() / channels_of(format) * bytes_per_texel(format));
  const auto as_unorm = [](float v, float top) { return std::clamp(v, 0.0f, 1.0f) * top + 0.5f; };
  for (size_t i = 0; i < values.size(); ++i) {
    if (format == Format::rg32f) {
      std::memcpy(&bytes[i * 4], &values[i], 4);
    } else if (format == Format::rgba8) {
      bytes[i] = static_cast<std::byte>(static_cast<uint8_t>(as_unorm(values[i], 255.0f)));
    } else {
      const uint16_t word = format == Format::rgba16 ? static_cast<uint16_t>(as_unorm(values[i], 65535.0f))
                                                     : glm::packHalf1x16(values[i]);
      std::memcpy(&bytes[i * 2], &word, 2);
    }
  }
  return bytes;
}

gpu::Image make_cube_image(gpu::Device& device, const std::string& name, Format format, uint32_t size,
                           const std::function<std::vector<float>(uint32_t face)>& face_texels) {
  NEPHO_ASSERT_OP(size & (size - 1), ==, 0u);
  const uint32_t mips = full_mip_levels(Extent2D{size, size}), channels = channels_of(format);
  gpu::Image image = device.create_image(
      {.name = name, .extent = Extent2D{size, size}, .format = format, .mip_levels = mips, .layers = 6, .cube = true});
  const std::vector<float> finest_weights = cube_texel_weights(size);
  for (uint32_t face = 0; face < 6; ++face) {
    std::vector<float> values = face_texels(face), weights = finest_weights;
    NEPHO_ASSERT_OP(values.size(), ==, size_t{size} * size * channels);
    std::vector<std::vector<std::byte>> texels;
    for (uint32_t mip = 0, n = size; mip < mips; ++mip, n /= 2) {
      if (mip > 0) halve_face(values, weights, 2 * n, channels);
      texels.push_back(packed_texels(format, values));
    }
    std::vector<gpu::ImageUpload> uploads;
    for (uint32_t mip = 0; mip < mips; ++mip)
      uploads.push_back({.image = &image, .bytes = texels[mip], .mip = mip, .layer = face});
    device.upload(uploads);
  }
  return image;
}

gpu::Image make_tile_image(gpu::Device& device, const std::string& name, Format format, uint32_t width, uint32_t height,
                           std::vector<float> texels) {
  const uint32_t mips = full_mip_levels(Extent2D{width, height}), channels = channels_of(format);
  NEPHO_ASSERT_OP(texels.size(), ==, size_t{width} * height * channels);
  gpu::Image image =
      device.create_image({.name = name, .extent = Extent2D{width, height}, .format = format, .mip_levels = mips});
  std::vector<std::vector<std::byte>> packed;
  std::vector<gpu::ImageUpload> uploads;
  for (uint32_t mip = 0; mip < mips; ++mip) {
    if (mip > 0) {
      const uint32_t w = std::max(1u, width / 2), h = std::max(1u, height / 2);
      texels = resized_rows(texels, width, w, 1, height, width, channels);              // h0 lines of w
      std::vector<float> columns = resized_rows(texels, height, h, w, w, 1, channels);  // w lines of h
      texels.assign(size_t{w} * h * channels, 0.0f);
      for (uint32_t y = 0; y < h; ++y)
        for (uint32_t x = 0; x < w; ++x)
          for (uint32_t c = 0; c < channels; ++c)
            texels[(size_t{y} * w + x) * channels + c] = columns[(size_t{x} * h + y) * channels + c];
      width = w;
      height = h;
    }
    packed.push_back(packed_texels(format, texels));
  }
  for (uint32_t mip = 0; mip < mips; ++mip) uploads.push_back({.image = &image, .bytes = packed[mip], .mip = mip});
  device.upload(uploads);
  return image;
}

}  // namespace nepho
