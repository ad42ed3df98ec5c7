#include "io/png.h"

#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <vector>

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

namespace {

constexpr size_t kMostBytes = size_t{1} << 30;

struct PngReader {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::string message;  ///< libpng's, of the first error
  std::vector<uint8_t> bytes;
  std::vector<png_bytep> rows;
  uint32_t width = 0, height = 0, channels = 0, bits = 0;

  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
  static void on_error(png_structp png, png_const_charp text) {
    static_cast<PngReader*>(png_get_error_ptr(png))->message = text;
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp, png_const_charp) {}

  /// libpng leaves by longjmp, so nothing in here may need a destructor.
  bool read(std::FILE* file) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    if (png) info = png_create_info_struct(png);
    if (!info) return false;
    if (setjmp(png_jmpbuf(png))) return false;
    png_init_io(png, file);
    png_read_info(png, info);
    png_set_expand(png);  // palettes, 1 to 4 bits, transparency as a colour
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    width = png_get_image_width(png, info);
    height = png_get_image_height(png, info);
    channels = png_get_channels(png, info);
    bits = png_get_bit_depth(png, info);
    const size_t row_bytes = png_get_rowbytes(png, info);
    if (row_bytes * height > kMostBytes) png_error(png, "more than 1 GiB of pixels");
    bytes.resize(row_bytes * height);
    rows.resize(height);
    for (size_t y = 0; y < height; ++y) rows[y] = &bytes[y * row_bytes];
    png_read_image(png, rows.data());
    png_read_end(png, nullptr);
    return true;
  }
};

}  // namespace

ImageBuffer read_png(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!file) throw fail(ErrorKind::input, "{}: no such file, or it cannot be read", path.string());
  PngReader reader;
  if (!reader.read(file.get()))
    throw fail(ErrorKind::input, "{}: not a whole PNG picture ({})", path.string(), reader.message);
  static constexpr const char* kNames[4][4] = {{"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
  ImageBuffer image{.width = reader.width, .height = reader.height, .channels = {}};
  const size_t count = size_t{image.width} * image.height;
  for (uint32_t c = 0; c < reader.channels; ++c) {
    ImageChannel& channel = image.channels.emplace_back(kNames[reader.channels - 1][c], std::vector<float>(count));
    for (size_t i = 0; i < count; ++i) {
      const size_t k = i * reader.channels + c;
      channel.values[i] = reader.bits == 16
                              ? static_cast<float>(reader.bytes[2 * k] * 256 + reader.bytes[2 * k + 1]) / 65535.0f
                              : static_cast<float>(reader.bytes[k]) / 255.0f;
    }
  }
  return image;
}

}  // namespace nepho
