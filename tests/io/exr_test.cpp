#include "io/exr.h"

#include <doctest/doctest.h>
#include <signal.h>
#include <sys/resource.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <limits>

#include "base/error.h"
#include "io/file_test_tools.h"

using namespace nepho;
using nepho::test::bytes_of;
using nepho::test::message_of;
using nepho::test::TempFolder;

namespace {

/// Values that a lossy or half-float path would change: subnormal, huge, negative zero, infinity, NaN.
ImageBuffer test_image(uint32_t width, uint32_t height) {
  ImageBuffer image{.width = width, .height = height, .channels = {}};
  uint32_t state = 12345;
  for (const char* name : {"R", "G", "B", "depth.Z", "position.lat_deg", "cloud.transmittance"}) {
    ImageChannel& channel = image.channels.emplace_back(ImageChannel{name, std::vector<float>(size_t{width} * height)});
    for (float& v : channel.values) {
      state = state * 1664525u + 1013904223u;
      v = std::ldexp(static_cast<float>(state >> 8) / 16777216.0f - 0.5f, static_cast<int>(state & 63u) - 32);
    }
  }
  image.channels[3].values[0] = 1e10f;
  image.channels[3].values[1] = std::numeric_limits<float>::denorm_min();
  image.channels[3].values[2] = -0.0f;
  image.channels[3].values[3] = std::numeric_limits<float>::infinity();
  image.channels[3].values[4] = std::numeric_limits<float>::quiet_NaN();
  return image;
}

ExrAttributes test_attributes() {
  ExrAttributes a;
  a.longitude_deg = 138.7274f;
  a.latitude_deg = 35.3606f;
  a.altitude_m = 3776.0f;
  a.cap_date = exr_cap_date("2026-06-20T23:30:00Z");
  a.utc_offset_s = 0.0f;
  a.world_to_camera = glm::mat4(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16);
  a.world_to_ndc = glm::mat4(2.0f);
  a.white_luminance = 1.0f;
  a.comments = "Fuji";
  a.strings["nepho:scene"] = "{\"time\":\"2026-06-20T23:30:00Z\"}";
  a.floats["nepho:fov"] = 45.0f;
  return a;
}

}  // namespace

TEST_CASE("exr: every channel comes back bit for bit under its own name") {
  const TempFolder folder;
  const ImageBuffer image = test_image(61, 37);
  write_exr(folder / "a.exr", image, {});
  const ExrFile read = read_exr(folder / "a.exr");
  CHECK(read.image.width == 61);
  CHECK(read.image.height == 37);
  REQUIRE(read.image.channels.size() == image.channels.size());
  for (const ImageChannel& channel : image.channels) {
    const ImageChannel* back = read.image.find(channel.name);
    REQUIRE_MESSAGE(back != nullptr, channel.name);
    size_t different = 0;
    for (size_t i = 0; i < channel.values.size(); ++i)
      different += std::bit_cast<uint32_t>(channel.values[i]) != std::bit_cast<uint32_t>(back->values[i]) ? 1u : 0u;
    CHECK_MESSAGE(different == 0, channel.name);
  }
}

TEST_CASE("exr: attributes come back, standard and our own") {
  const TempFolder folder;
  const ExrAttributes written = test_attributes();
  write_exr(folder / "a.exr", test_image(8, 8), written);
  const ExrAttributes read = read_exr(folder / "a.exr").attributes;
  CHECK(read == written);
  CHECK(read.cap_date == "2026:06:20 23:30:00");
}

TEST_CASE("exr: the header names ZIP, 32-bit floats and increasing lines, and a matrix is stored for row vectors") {
  const TempFolder folder;
  ExrAttributes a;
  a.world_to_camera = glm::mat4(1.0f);
  (*a.world_to_camera)[3] = glm::vec4(100.0f, 200.0f, 300.0f, 1.0f);  // a translation
  write_exr(folder / "a.exr", ImageBuffer{.width = 1, .height = 1, .channels = {{"R", {1.0f}}}}, a);
  const std::string bytes = bytes_of(folder / "a.exr");
  const auto value_after = [&](const std::string& name_and_type, size_t skip) {
    const size_t at = bytes.find(name_and_type);
    REQUIRE(at != std::string::npos);
    return bytes.substr(at + name_and_type.size() + skip);
  };
  using namespace std::string_literals;
  CHECK(value_after("compression\0compression\0"s, 4)[0] == 3);  // OpenEXR file layout: 3 is ZIP, 16 lines
  CHECK(value_after("lineOrder\0lineOrder\0"s, 4)[0] == 0);
  CHECK(value_after("channels\0chlist\0"s, 4).substr(0, 6) == "R\0\2\0\0\0"s);  // pixel type 2 is FLOAT
  // OpenEXR writes matrices row by row and multiplies row vectors: the translation is the last row, floats 12..14.
  const std::string matrix = value_after("worldToCamera\0m44f\0"s, 4);
  CHECK(matrix.substr(48, 12) == "\0\0\xc8\x42\0\0\x48\x43\0\0\x96\x43"s);  // 100, 200, 300 little endian
}

TEST_CASE("exr: writing the same picture twice gives the same bytes") {
  const TempFolder folder;
  write_exr(folder / "a.exr", test_image(300, 200), test_attributes());
  write_exr(folder / "b.exr", test_image(300, 200), test_attributes());
  CHECK(bytes_of(folder / "a.exr") == bytes_of(folder / "b.exr"));
}

TEST_CASE("exr: an output that cannot be written leaves nothing and says which") {
  const TempFolder folder;
  const auto missing = folder / "no/such/a.exr";
  CHECK(message_of([&] { write_exr(missing, test_image(8, 8), {}); }, ErrorKind::failure).find(missing.string()) == 0);
  CHECK(folder.empty());
}

TEST_CASE("exr: a disk that refuses half way, or at the last bytes, leaves no partial file") {
  const TempFolder folder;
  write_exr(folder / "whole.exr", test_image(64, 64), {});
  const auto whole_size = std::filesystem::file_size(folder / "whole.exr");
  std::filesystem::remove(folder / "whole.exr");
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto old_handler = signal(SIGXFSZ, SIG_IGN);
  for (const rlim_t limit : {rlim_t{5000}, static_cast<rlim_t>(whole_size - 1)}) {
    const rlimit tight{limit, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &tight);
    const std::string message =
        message_of([&] { write_exr(folder / "a.exr", test_image(64, 64), {}); }, ErrorKind::failure);
    setrlimit(RLIMIT_FSIZE, &before);
    CHECK(message == (folder / "a.exr").string() + ": cannot be written (File too large)");
    CHECK(folder.empty());
  }
  signal(SIGXFSZ, old_handler);
}

TEST_CASE("exr: missing, foreign and cut off files are input errors that name the file") {
  const TempFolder folder;
  const auto read_message = [&](const std::string& name) {
    return message_of([&] { read_exr(folder / name); }, ErrorKind::input);
  };
  CHECK(read_message("missing.exr") == (folder / "missing.exr").string() + ": no such file");
  std::ofstream(folder / "text.exr") << "not a picture";
  CHECK(read_message("text.exr") == (folder / "text.exr").string() + ": is not an OpenEXR file");
  std::ofstream(folder / "empty.exr").flush();
  CHECK(read_message("empty.exr") == (folder / "empty.exr").string() + ": is not an OpenEXR file");
  write_exr(folder / "whole.exr", test_image(64, 64), {});
  const std::string whole = bytes_of(folder / "whole.exr");
  for (const size_t kept : {size_t{12}, size_t{200}, whole.size() / 2, whole.size() - 1}) {
    std::ofstream(folder / "cut.exr", std::ios::binary) << whole.substr(0, kept);
    const std::string message = read_message("cut.exr");
    CHECK(message.find((folder / "cut.exr").string() + ": is a damaged OpenEXR file") == 0);
    CHECK(message.find('\n') == std::string::npos);
  }
  std::string huge = whole;  // a data window of 2^30 x 2^30
  const size_t at = huge.find(std::string("dataWindow\0box2i\0", 17)) + 17 + 4;
  for (const size_t corner : {size_t{8}, size_t{12}}) huge.replace(at + corner, 4, std::string("\0\0\0\x40", 4));
  std::ofstream(folder / "huge.exr", std::ios::binary) << huge;
  CHECK(read_message("huge.exr").find((folder / "huge.exr").string()) == 0);
}
