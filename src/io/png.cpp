#include "io/png.h"

#include <png.h>

#include <limits>

#include "base/error.h"
#include "base/files.h"

namespace nepho {

void write_png(const std::filesystem::path& path, uint32_t width, uint32_t height, std::span<const uint8_t> rgb) {
  const uint64_t row_bytes = uint64_t{width} * 3;
  NEPHO_ASSERT_OP(uint64_t{rgb.size()}, ==, row_bytes * height);
  // libpng's simplified writer counts the picture's bytes in 32 bits.
  if (width == 0 || height == 0 || row_bytes * height > std::numeric_limits<uint32_t>::max())
    throw fail(ErrorKind::failure, "{}: {}x{} is not a size that PNG can be written in; use .exr", path.string(), width,
               height);
  write_whole_file(path, [&](const std::filesystem::path& temporary) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = width;
    image.height = height;
    image.format = PNG_FORMAT_RGB;  // 8 bits are sRGB by libpng's definition; it writes the sRGB chunk itself
    if (!png_image_write_to_file(&image, temporary.c_str(), 0, rgb.data(), 0, nullptr))
      throw fail(ErrorKind::failure, "{}: cannot be written ({})", path.string(), image.message);
  });
}

}  // namespace nepho
