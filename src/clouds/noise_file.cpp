#include "clouds/noise_file.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "clouds/blue_noise.h"
#include "io/exr.h"
#include "io/png.h"

namespace nepho {
namespace {

constexpr uint32_t kSmallest = 8, kLargest = 256;

std::string extension_of(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_raw(const std::string& file) {
  const std::string extension = extension_of(file);
  return extension == ".bin" || extension == ".raw";
}

ImageBuffer read_picture(const std::string& file) {
  const std::string extension = extension_of(file);
  if (extension == ".png") return read_png(file);
  if (extension == ".exr") return read_exr(file).image;
  throw fail(ErrorKind::input,
             "{}: not a noise texture by its name; .bin or .raw (bytes), .png or .exr (slices) are read", file);
}

/// The side of a cube of `count` texels; 0 when it is none.
uint32_t side_of(uint64_t count) {
  const auto side = static_cast<uint64_t>(std::llround(std::cbrt(static_cast<double>(count))));
  return side * side * side == count ? static_cast<uint32_t>(side) : 0;
}

void check_side(const std::string& file, uint32_t side) {
  if (side < kSmallest || side > kLargest || !std::has_single_bit(side))
    throw fail(ErrorKind::input, "{}: a cube of {} texels a side; 8, 16, 32, 64, 128 or 256 are read", file, side);
}

/// All bytes of a file that is not larger than any that is read.
std::string read_bytes(const std::string& file) {
  std::error_code unknown;  // a missing file is read_text_file()'s to tell
  const uintmax_t size = std::filesystem::file_size(file, unknown);
  if (!unknown && size > uintmax_t{kLargest} * kLargest * kLargest * 4)
    throw fail(ErrorKind::input, "{}: {} bytes; noise textures of up to {} texels a side are read", file, size,
               kLargest);
  return read_text_file(file);
}

NoiseVolumeFile read_raw_volume(const std::string& file, uint32_t channels) {
  const std::string bytes = read_bytes(file);
  NoiseVolumeFile volume;
  uint32_t stored = channels;
  volume.size = bytes.size() % channels == 0 ? side_of(bytes.size() / channels) : 0;
  if (volume.size == 0 && channels == 3 && bytes.size() % 4 == 0) volume.size = side_of(bytes.size() / (stored = 4));
  if (volume.size == 0)
    throw fail(ErrorKind::input, "{}: {} bytes, which is not {}; a volume of N x N x N texels is read", file,
               bytes.size(), channels == 1 ? "a cube of a whole number" : "3 or 4 times a cube of a whole number");
  check_side(file, volume.size);
  for (uint32_t c = 0; c < channels; ++c) {
    std::vector<float>& plane = volume.planes.emplace_back(bytes.size() / stored);
    for (size_t i = 0; i < plane.size(); ++i)
      plane[i] = static_cast<float>(static_cast<unsigned char>(bytes[i * stored + c])) / 255.0f;
  }
  return volume;
}

/// The channels that count, in the order of `size` x `size` slices: `slices` of them.
std::vector<std::vector<float>> slices_of(const std::string& file, const ImageBuffer& picture, uint32_t size,
                                          uint32_t slices, uint32_t channels) {
  std::vector<const ImageChannel*> wanted;
  if (channels == 3) {
    for (const char* name : {"R", "G", "B"})
      if (const ImageChannel* channel = picture.find(name)) wanted.push_back(channel);
  } else if (!picture.channels.empty()) {
    const ImageChannel* red = picture.find("R");
    wanted.push_back(red ? red : &picture.channels.front());
  }
  if (wanted.size() != channels)
    throw fail(ErrorKind::input, "{}: {} channel(s), where {} are needed{}", file, picture.channels.size(), channels,
               channels == 3 ? ": R, G and B" : "");
  const bool beside = picture.width != size;  // slices side by side
  std::vector<std::vector<float>> planes;
  for (const ImageChannel* channel : wanted) {
    if (!std::all_of(channel->values.begin(), channel->values.end(), [](float v) { return std::isfinite(v); }))
      throw fail(ErrorKind::input, "{}: channel {} holds values that are not finite; noise must be numbers", file,
                 channel->name);
    std::vector<float>& plane = planes.emplace_back();
    plane.reserve(size_t{size} * size * slices);
    for (uint32_t z = 0; z < slices; ++z)
      for (uint32_t y = 0; y < size; ++y) {
        const size_t row = beside ? size_t{y} * picture.width + size_t{z} * size : (size_t{z} * size + y) * size;
        plane.insert(plane.end(), &channel->values[row], &channel->values[row] + size);
      }
  }
  return planes;
}

}  // namespace

NoiseVolumeFile read_noise_volume(const std::string& file, uint32_t channels) {
  NEPHO_ASSERT(channels == 1 || channels == 3);
  if (is_raw(file)) return read_raw_volume(file, channels);
  const ImageBuffer picture = read_picture(file);
  NoiseVolumeFile volume;
  volume.size = std::min(picture.width, picture.height);
  if (uint64_t{volume.size} * volume.size != std::max(picture.width, picture.height))
    throw fail(ErrorKind::input,
               "{}: a picture of {} x {}; a volume is N slices of N x N, so N x N*N or N*N x N pixels (128 x 16384)",
               file, picture.width, picture.height);
  check_side(file, volume.size);
  volume.planes = slices_of(file, picture, volume.size, volume.size, channels);
  return volume;
}

std::vector<uint8_t> read_blue_noise(const std::string& file) {
  std::vector<float> values;
  if (is_raw(file)) {
    const std::string bytes = read_bytes(file);
    if (bytes.size() != size_t{kBlueSize} * kBlueSize * kBlueSlices)
      throw fail(ErrorKind::input, "{}: {} bytes; blue noise is {} slices of {} x {} bytes, {} in all", file,
                 bytes.size(), kBlueSlices, kBlueSize, kBlueSize, kBlueSize * kBlueSize * kBlueSlices);
    for (const char c : bytes) values.push_back(static_cast<float>(static_cast<unsigned char>(c)));
  } else {
    const ImageBuffer picture = read_picture(file);
    constexpr uint32_t kLong = kBlueSize * kBlueSlices;
    const bool below = picture.width == kBlueSize && picture.height == kLong;
    const bool beside = picture.width == kLong && picture.height == kBlueSize;
    if (!below && !beside)
      throw fail(ErrorKind::input, "{}: a picture of {} x {}; blue noise is {} slices of {} x {}: {} x {} or {} x {}",
                 file, picture.width, picture.height, kBlueSlices, kBlueSize, kBlueSize, kBlueSize, kLong, kLong,
                 kBlueSize);
    values = slices_of(file, picture, kBlueSize, kBlueSlices, 1).front();
  }
  std::vector<uint8_t> noise;
  if (!equalise_slices(values, noise))
    throw fail(ErrorKind::input, "{}: a slice of it holds one value only; blue noise varies within every slice", file);
  return noise;
}

}  // namespace nepho
