#include "io/png.h"

#include <doctest/doctest.h>
#include <png.h>

#include <numeric>
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
