#include "terrain/block_codec.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace nepho {

namespace {

static_assert(std::endian::native == std::endian::little, "files of another byte order would need another magic");

enum class Packing : uint32_t { u8 = 1, i16 = 2, f32 = 4 };  // bytes a number

struct Header {
  char magic[8] = {'N', 'E', 'P', 'H', 'O', 'B', 'K', '1'};
  uint32_t checksum = 0;  // CRC-32 of all that follows it
  uint32_t key_bytes = 0;
  uint32_t width = 0, height = 0, bands = 0;
  uint32_t packing = 0;
  uint32_t flags_bytes = 0;  // 0: all pixels are valid
  uint32_t packed_bytes = 0;
};
static_assert(sizeof(Header) == 40);
constexpr size_t kChecked = offsetof(Header, key_bytes);
constexpr uint32_t kMostPixels = Raster::kBlockSize * Raster::kBlockSize, kMostBands = 16;

uint32_t checksum_of(std::span<const std::byte> bytes) {
  return static_cast<uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

/// The narrowest type that gives back the very bits.
Packing packing_of(const std::vector<float>& values) {
  const auto all = [&](auto fits) { return std::all_of(values.begin(), values.end(), fits); };
  const auto is_whole = [](float v, float low, float high) {
    return v >= low && v <= high && static_cast<float>(static_cast<int32_t>(v)) == v && !(v == 0.0f && std::signbit(v));
  };
  if (all([&](float v) { return is_whole(v, 0.0f, 255.0f); })) return Packing::u8;
  if (all([&](float v) { return is_whole(v, -32768.0f, 32767.0f); })) return Packing::i16;
  return Packing::f32;
}

/// Numbers as byte planes: the high bytes of neighbours are alike.
std::vector<std::byte> planes_of(const std::vector<float>& values, Packing packing) {
  const size_t count = values.size(), size = static_cast<size_t>(packing);
  std::vector<std::byte> out(count * size);
  for (size_t i = 0; i < count; ++i) {
    const uint32_t bits = packing == Packing::f32 ? std::bit_cast<uint32_t>(values[i])
                                                  : static_cast<uint32_t>(static_cast<int32_t>(values[i]));
    for (size_t b = 0; b < size; ++b) out[b * count + i] = static_cast<std::byte>(bits >> (8 * b));
  }
  return out;
}

std::vector<float> values_of(std::span<const std::byte> planes, Packing packing) {
  const size_t size = static_cast<size_t>(packing), count = planes.size() / size;
  std::vector<float> out(count);
  for (size_t i = 0; i < count; ++i) {
    uint32_t bits = 0;
    for (size_t b = 0; b < size; ++b) bits |= static_cast<uint32_t>(planes[b * count + i]) << (8 * b);
    out[i] = packing == Packing::f32   ? std::bit_cast<float>(bits)
             : packing == Packing::i16 ? static_cast<float>(static_cast<int16_t>(bits))
                                       : static_cast<float>(bits);
  }
  return out;
}

}  // namespace

std::vector<std::byte> encode_block(const RasterBlock& block, uint32_t bands, const std::string& key) {
  Header header;
  const Packing packing = packing_of(block.values);
  const bool all_valid = std::all_of(block.valid.begin(), block.valid.end(), [](uint8_t v) { return v == 1; });
  std::vector<std::byte> plain = planes_of(block.values, packing);
  if (!all_valid) {
    const auto* const flags = reinterpret_cast<const std::byte*>(block.valid.data());
    plain.insert(plain.end(), flags, flags + block.valid.size());
  }
  uLongf packed = compressBound(static_cast<uLong>(plain.size()));
  std::vector<std::byte> out(sizeof(Header) + key.size() + packed);
  std::byte* const data = out.data() + sizeof(Header) + key.size();
  if (compress2(reinterpret_cast<Bytef*>(data), &packed, reinterpret_cast<const Bytef*>(plain.data()),
                static_cast<uLong>(plain.size()), 1) != Z_OK)
    return {};
  out.resize(sizeof(Header) + key.size() + packed);
  header.key_bytes = static_cast<uint32_t>(key.size());
  header.width = block.width;
  header.height = block.height;
  header.bands = bands;
  header.packing = static_cast<uint32_t>(packing);
  header.flags_bytes = all_valid ? 0 : static_cast<uint32_t>(block.valid.size());
  header.packed_bytes = static_cast<uint32_t>(packed);
  std::memcpy(out.data(), &header, sizeof(header));
  std::memcpy(out.data() + sizeof(Header), key.data(), key.size());
  header.checksum = checksum_of(std::span(out).subspan(kChecked));
  std::memcpy(out.data(), &header, sizeof(header));
  return out;
}

std::optional<RasterBlock> decode_block(std::span<const std::byte> bytes, uint32_t bands, const std::string& key) {
  Header header;
  if (bytes.size() < sizeof(header)) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (std::memcmp(header.magic, Header{}.magic, sizeof(header.magic)) != 0) return std::nullopt;
  if (header.checksum != checksum_of(bytes.subspan(kChecked))) return std::nullopt;
  const uint64_t pixels = uint64_t{header.width} * header.height;
  if (header.key_bytes != key.size() || header.bands != bands || bands > kMostBands || pixels == 0 ||
      pixels > kMostPixels || (header.flags_bytes != 0 && header.flags_bytes != pixels) ||
      bytes.size() != sizeof(header) + key.size() + header.packed_bytes ||
      std::memcmp(bytes.data() + sizeof(header), key.data(), key.size()) != 0)
    return std::nullopt;
  const auto packing = static_cast<Packing>(header.packing);
  if (packing != Packing::u8 && packing != Packing::i16 && packing != Packing::f32) return std::nullopt;
  const size_t value_bytes = pixels * bands * static_cast<size_t>(packing);
  std::vector<std::byte> plain(value_bytes + header.flags_bytes);
  uLongf size = static_cast<uLongf>(plain.size());
  if (uncompress(reinterpret_cast<Bytef*>(plain.data()), &size,
                 reinterpret_cast<const Bytef*>(bytes.data() + sizeof(header) + key.size()),
                 static_cast<uLong>(header.packed_bytes)) != Z_OK ||
      size != plain.size())
    return std::nullopt;
  RasterBlock block{.width = header.width, .height = header.height, .values = {}, .valid = {}};
  block.values = values_of(std::span(plain).first(value_bytes), packing);
  block.valid.assign(pixels, 1);
  if (header.flags_bytes != 0) std::memcpy(block.valid.data(), plain.data() + value_bytes, header.flags_bytes);
  return block;
}

}  // namespace nepho
