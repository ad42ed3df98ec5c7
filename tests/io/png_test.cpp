#include "io/png.h"

#include <doctest/doctest.h>
#include <png.h>

#include <cstdio>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/file_test_tools.h"

using namespace nepho;
using nepho::test::bytes_of;
using nepho::test::message_of;
using nepho::test::TempFolder;

TEST_CASE("png: pixels come back exactly, with an sRGB chunk and no time of day") {
  const TempFolder folder;
  std::vector<uint8_t> rgb(size_t{19} * 7 * 3);
  std::iota(rgb.begin(), rgb.end(), uint8_t{0});
  write_png(folder / "a.png", 19, 7, rgb);

  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_file(&image, (folder / "a.png").c_str()));
  CHECK(image.width == 19);
  CHECK(image.height == 7);
  CHECK(image.format == PNG_FORMAT_RGB);
  std::vector<uint8_t> back(PNG_IMAGE_SIZE(image));
  REQUIRE(png_image_finish_read(&image, nullptr, back.data(), 0, nullptr));
  CHECK(back == rgb);

  const std::string bytes = bytes_of(folder / "a.png");
  CHECK(bytes.find("sRGB") != std::string::npos);
  CHECK(bytes.find("tIME") == std::string::npos);
  write_png(folder / "b.png", 19, 7, rgb);
  CHECK(bytes_of(folder / "b.png") == bytes);
}

TEST_CASE("png: an output that cannot be written leaves nothing and names the path") {
  const TempFolder folder;
  const std::vector<uint8_t> rgb(3, uint8_t{128});
  const auto path = folder / "none/a.png";
  const std::string message = message_of([&] { write_png(path, 1, 1, rgb); }, ErrorKind::failure);
  CHECK(message.find(path.string()) == 0);
  CHECK(folder.empty());
}

TEST_CASE("png: what was written is read as it was, row 0 on top") {
  const TempFolder folder;
  std::vector<uint8_t> rgb(size_t{5} * 3 * 3);
  std::iota(rgb.begin(), rgb.end(), uint8_t{100});
  write_png(folder / "a.png", 5, 3, rgb);
  const ImageBuffer image = read_png(folder / "a.png");
  CHECK(image.width == 5);
  CHECK(image.height == 3);
  REQUIRE(image.channels.size() == 3);
  for (size_t c = 0; c < 3; ++c) {
    CHECK(image.channels[c].name == std::string(1, "RGB"[c]));
    for (size_t i = 0; i < 15; ++i) CHECK(image.channels[c].values[i] == doctest::Approx(rgb[3 * i + c] / 255.0));
  }
}

TEST_CASE("png: 16 bits, grey with alpha, one bit and interlaced pictures are read as stored") {
  const TempFolder folder;
  const auto write = [&](const char* name, int bits, int type, int interlace, std::vector<std::vector<uint8_t>> rows) {
    std::FILE* file = std::fopen((folder / name).c_str(), "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, file);
    png_set_IHDR(png, info, 2, static_cast<png_uint_32>(rows.size()), bits, type, interlace,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_gAMA(png, info, 1.0);  // must not matter
    std::vector<png_bytep> pointers;
    for (auto& row : rows) pointers.push_back(row.data());
    png_set_rows(png, info, pointers.data());
    png_write_png(png, info, PNG_TRANSFORM_IDENTITY, nullptr);
    png_destroy_write_struct(&png, &info);
    std::fclose(file);
  };
  write("deep.png", 16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_ADAM7, {{0x12, 0x34, 0xff, 0xff}, {0, 0, 0x80, 0}});
  const ImageBuffer deep = read_png(folder / "deep.png");
  REQUIRE(deep.channels.size() == 1);
  CHECK(deep.channels[0].name == "Y");
  CHECK(deep.channels[0].values[0] == doctest::Approx(0x1234 / 65535.0));
  CHECK(deep.channels[0].values[1] == 1.0f);
  CHECK(deep.channels[0].values[2] == 0.0f);
  CHECK(deep.channels[0].values[3] == doctest::Approx(0x8000 / 65535.0));

  write("alpha.png", 8, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_INTERLACE_NONE, {{10, 20, 30, 40}});
  const ImageBuffer alpha = read_png(folder / "alpha.png");
  REQUIRE(alpha.channels.size() == 2);
  CHECK(alpha.channels[1].name == "A");
  CHECK(alpha.channels[0].values[1] == doctest::Approx(30 / 255.0));
  CHECK(alpha.channels[1].values[0] == doctest::Approx(20 / 255.0));

  write("bit.png", 1, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, {{0x40}});
  CHECK(read_png(folder / "bit.png").channels[0].values == std::vector<float>{0.0f, 1.0f});
}

TEST_CASE("png: a file that is missing, cut off or no PNG is named") {
  const TempFolder folder;
  std::vector<uint8_t> rgb(size_t{64} * 64 * 3);
  for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<uint8_t>(i * i >> 3);
  write_png(folder / "a.png", 64, 64, rgb);
  const std::string bytes = bytes_of(folder / "a.png");
  std::ofstream(folder / "cut.png", std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size() / 2));
  std::ofstream(folder / "text.png") << "no picture at all";
  for (const char* name : {"none.png", "cut.png", "text.png"}) {
    const std::string message = message_of([&] { read_png(folder / name); }, ErrorKind::input);
    CHECK(message.find((folder / name).string()) == 0);
  }
}
