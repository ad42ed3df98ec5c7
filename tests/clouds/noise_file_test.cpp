#include "clouds/noise_file.h"

#include <doctest/doctest.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "clouds/blue_noise.h"
#include "clouds/cloud_noise.h"
#include "gpu/gpu_fixture.h"
#include "io/exr.h"
#include "io/file_test_tools.h"
#include "io/png.h"

using namespace nepho;
using test::message_of;
using test::TempFolder;

namespace {

void write_bytes(const std::filesystem::path& path, const std::vector<uint8_t>& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// Noise of any kind, of few enough values to have equal ones.
std::vector<uint8_t> some_bytes(size_t count, uint32_t seed = 3) {
  std::vector<uint8_t> bytes(count);
  for (uint8_t& b : bytes) b = static_cast<uint8_t>((seed = seed * 1664525u + 1013904223u) >> 26);
  return bytes;
}

void write_grey_png(const std::filesystem::path& path, uint32_t width, uint32_t height,
                    const std::vector<uint8_t>& grey) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = PNG_FORMAT_GRAY;
  REQUIRE(png_image_write_to_file(&image, path.c_str(), 0, grey.data(), 0, nullptr));
}

std::string volume_error(const std::filesystem::path& path, uint32_t channels = 1) {
  const std::string message = message_of([&] { read_noise_volume(path.string(), channels); }, ErrorKind::input);
  CHECK(message.find(path.string()) == 0);
  return message;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("noise files: bytes, a strip of pictures and a row of them are the same volume") {
  const TempFolder folder;
  const std::vector<uint8_t> bytes = some_bytes(8 * 8 * 8);
  write_bytes(folder / "a.bin", bytes);
  write_grey_png(folder / "below.png", 8, 64, bytes);
  std::vector<uint8_t> beside(512);
  ImageBuffer exr{
      .width = 64, .height = 8, .channels = {{"B", std::vector<float>(512, 0.5f)}, {"R", std::vector<float>(512)}}};
  for (size_t z = 0; z < 8; ++z)
    for (size_t y = 0; y < 8; ++y)
      for (size_t x = 0; x < 8; ++x) {
        beside[y * 64 + z * 8 + x] = bytes[(z * 8 + y) * 8 + x];
        exr.channels[1].values[y * 64 + z * 8 + x] = static_cast<float>(bytes[(z * 8 + y) * 8 + x]) / 255.0f;
      }
  write_grey_png(folder / "beside.PNG", 64, 8, beside);
  write_exr(folder / "beside.exr", exr, {});
  const NoiseVolumeFile raw = read_noise_volume(folder / "a.bin", 1);
  CHECK(raw.size == 8);
  REQUIRE(raw.planes.size() == 1);
  for (size_t i = 0; i < 512; ++i) CHECK(raw.planes[0][i] == doctest::Approx(bytes[i] / 255.0));
  for (const char* name : {"below.png", "beside.PNG", "beside.exr"}) {
    CAPTURE(name);
    const NoiseVolumeFile other = read_noise_volume((folder / name).string(), 1);
    CHECK(other.size == 8);
    CHECK(other.planes == raw.planes);
  }
}

TEST_CASE("noise files: three channels come from RGB and RGBA bytes and from pictures") {
  const TempFolder folder;
  const std::vector<uint8_t> rgb = some_bytes(512 * 3);
  std::vector<uint8_t> rgba;
  for (size_t i = 0; i < 512; ++i) rgba.insert(rgba.end(), {rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2], 255});
  write_bytes(folder / "rgb.raw", rgb);
  write_bytes(folder / "rgba.raw", rgba);
  write_png(folder / "rgb.png", 8, 64, rgb);
  const NoiseVolumeFile first = read_noise_volume((folder / "rgb.raw").string(), 3);
  CHECK(first.size == 8);
  REQUIRE(first.planes.size() == 3);
  CHECK(first.planes[1][7] == doctest::Approx(rgb[22] / 255.0));
  CHECK(read_noise_volume((folder / "rgba.raw").string(), 3).planes == first.planes);
  CHECK(read_noise_volume((folder / "rgb.png").string(), 3).planes == first.planes);
  CHECK(read_noise_volume((folder / "rgb.png").string(), 1).planes[0] == first.planes[0]);
}

TEST_CASE("noise files: what is wrong with a file is said in one line") {
  const TempFolder folder;
  CHECK(contains(volume_error(folder / "none.bin"), "none.bin"));
  CHECK(contains(volume_error(folder / "none.png"), "no such file"));
  CHECK(contains(volume_error(folder / "shape.tif"), ".bin or .raw"));
  write_bytes(folder / "odd.bin", some_bytes(1000 + 1));
  CHECK(contains(volume_error(folder / "odd.bin"), "1001 bytes"));
  write_bytes(folder / "empty.bin", {});
  CHECK(contains(volume_error(folder / "empty.bin"), "0 bytes"));
  write_bytes(folder / "ten.bin", some_bytes(1000));
  CHECK(contains(volume_error(folder / "ten.bin"), "10 texels a side"));
  write_bytes(folder / "four.bin", some_bytes(64));
  CHECK(contains(volume_error(folder / "four.bin"), "4 texels a side"));
  write_bytes(folder / "huge.raw", {});
  std::filesystem::resize_file(folder / "huge.raw", size_t{300} * 300 * 300 * 4);
  CHECK(contains(volume_error(folder / "huge.raw"), "up to 256"));
  std::filesystem::create_directory(folder / "folder.bin");
  volume_error(folder / "folder.bin");
  std::filesystem::create_directory(folder / "folder.png");
  volume_error(folder / "folder.png");
  write_bytes(folder / "grey.bin", some_bytes(512));
  CHECK(contains(volume_error(folder / "grey.bin", 3), "3 or 4 times a cube"));
  write_grey_png(folder / "square.png", 16, 16, some_bytes(256));
  CHECK(contains(volume_error(folder / "square.png"), "16 x 16"));
  write_grey_png(folder / "grey.png", 8, 64, some_bytes(512));
  CHECK(contains(volume_error(folder / "grey.png", 3), "R, G and B"));
  write_bytes(folder / "text.png", {'h', 'e', 'l', 'l', 'o'});
  CHECK(contains(volume_error(folder / "text.png"), "PNG"));
  ImageBuffer exr{.width = 8, .height = 64, .channels = {{"Y", std::vector<float>(512, 0.5f)}}};
  exr.channels[0].values[77] = std::numeric_limits<float>::quiet_NaN();
  write_exr(folder / "nan.exr", exr, {});
  CHECK(contains(volume_error(folder / "nan.exr"), "not finite"));
}

TEST_CASE("noise files: blue noise keeps its values, as bytes and as pictures") {
  const TempFolder folder;
  const std::vector<uint8_t> noise = make_blue_noise();
  write_bytes(folder / "a.bin", noise);
  write_grey_png(folder / "a.png", kBlueSize, kBlueSize * kBlueSlices, noise);
  CHECK(read_blue_noise((folder / "a.bin").string()) == noise);
  CHECK(read_blue_noise((folder / "a.png").string()) == noise);
  const auto error = [](const std::filesystem::path& path) {
    return message_of([&] { read_blue_noise(path.string()); }, ErrorKind::input);
  };
  write_bytes(folder / "flat.bin", std::vector<uint8_t>(noise.size(), 7));
  CHECK(contains(error(folder / "flat.bin"), "one value only"));
  write_bytes(folder / "short.bin", some_bytes(4096));
  CHECK(contains(error(folder / "short.bin"), "65536 in all"));
  write_grey_png(folder / "small.png", 64, 64, some_bytes(4096));
  CHECK(contains(error(folder / "small.png"), "64 x 1024"));
  CHECK(contains(error(folder / "none.png"), "no such file"));
}

TEST_CASE_FIXTURE(GpuFixture, "cloud noise: volumes from files take their place, normal whatever they held") {
  const TempFolder folder;
  // Skewed on purpose: squares of uniform values.
  std::vector<uint8_t> skewed(16 * 16 * 16);
  uint32_t state = 9;
  for (uint8_t& b : skewed) {
    const double u = ((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24;
    b = static_cast<uint8_t>(255.0 * u * u);
  }
  write_bytes(folder / "shape.bin", skewed);
  write_bytes(folder / "detail.raw", some_bytes(8 * 8 * 8));
  write_bytes(folder / "turbulence.raw", some_bytes(8 * 8 * 8 * 3));
  std::vector<uint8_t> blue = make_blue_noise();
  std::reverse(blue.begin(), blue.end());
  write_bytes(folder / "blue.raw", blue);
  CloudNoiseParams params;
  params.shape.file = (folder / "shape.bin").string();
  params.detail.file = (folder / "detail.raw").string();
  params.turbulence.file = (folder / "turbulence.raw").string();
  params.blue_noise_file = (folder / "blue.raw").string();
  const CloudNoise noise(device, params);
  CHECK(noise.shape_size() == 16);
  CHECK(noise.detail_size() == 8);
  CHECK(noise.turbulence_size() == 8);
  CHECK(noise.shape().desc().mip_levels == 5);
  CHECK(noise.variances()[3].size() == 5);
  CHECK(noise.variances()[3][0] == doctest::Approx(1.0).epsilon(1e-3));
  CHECK(noise.variances()[3][1] ==
        doctest::Approx(1.0 / 8.0).epsilon(0.15));  // white noise: a mip keeps an eighth, filtered or not
  const std::vector<std::byte> bytes = device.download(noise.shape());
  std::vector<uint16_t> words(4096);
  std::memcpy(words.data(), bytes.data(), 2 * words.size());
  const auto above_one = std::count_if(words.begin(), words.end(), [](uint16_t w) { return w > 0.625 * 65535.0; });
  CHECK(static_cast<double>(above_one) / 4096.0 == doctest::Approx(0.159).epsilon(0.05));
  // Its order stays: the brightest texel of the file is the brightest here.
  const auto brightest = std::max_element(skewed.begin(), skewed.end()) - skewed.begin();
  CHECK(words[static_cast<size_t>(brightest)] == *std::max_element(words.begin(), words.end()));
  const std::vector<std::byte> blue_back = device.download(noise.blue());
  CHECK(std::equal(blue.begin(), blue.end(), blue_back.begin(), blue_back.end(),
                   [](uint8_t a, std::byte b) { return std::byte{a} == b; }));

  write_bytes(folder / "flat.bin", std::vector<uint8_t>(512, 128));
  params.shape.file = (folder / "flat.bin").string();
  const std::string message = message_of([&] { CloudNoise(device, params); }, ErrorKind::input);
  CHECK(contains(message, "flat.bin"));
  CHECK(contains(message, "one value only"));
}
