#include "terrain/baked_raster.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <span>

#include "base/blob_cache.h"
#include "base/files.h"
#include "io/raster_grid.h"

namespace nepho {

namespace {

static_assert(std::endian::native == std::endian::little, "files of another byte order would need another magic");

constexpr uint32_t kSide = Raster::kBlockSize, kMostBands = 4;

/// Header, then the places of all blocks, row by row from the north west, then the blocks.
struct Header {
  char magic[8] = {'N', 'E', 'P', 'H', 'B', 'A', 'K', '1'};
  uint64_t checksum = 0;  // of all that follows it
  uint32_t width = 0, height = 0, bands = 0;
  uint32_t wraps = 0, ellipsoid = 0, unused = 0;
  double west_deg = 0.0, south_deg = 0.0, east_deg = 0.0, north_deg = 0.0;
  double oversampling = 1.0, opacity = 1.0;
};
static_assert(sizeof(Header) == 88);
constexpr size_t kChecked = offsetof(Header, width);

struct Place {
  uint64_t first = 0, bytes = 0;  // in the file
};

/// What neighbours to the west, north and north west make of a number, in arithmetic modulo 2^16.
uint16_t predicted(std::span<const uint16_t> plane, uint32_t width, uint32_t x, uint32_t y) {
  const size_t i = size_t{y} * width + x;
  if (y == 0) return x == 0 ? uint16_t{0} : plane[i - 1];
  if (x == 0) return plane[i - width];
  return static_cast<uint16_t>(plane[i - 1] + plane[i - width] - plane[i - width - 1]);
}

/// Small differences of either sign as small numbers.
uint16_t zigzag(uint16_t v) { return static_cast<uint16_t>((v << 1) ^ (v & 0x8000u ? 0xffffu : 0u)); }
uint16_t unzigzag(uint16_t v) { return static_cast<uint16_t>((v >> 1) ^ (v & 1u ? 0xffffu : 0u)); }

/// Every band after the first as its difference from the one before: greys are free then. Low bytes of all, high bytes
/// of all, and the flags.
std::vector<std::byte> encode(const RasterBlock& block, uint32_t bands, const std::string& path) {
  const size_t pixels = block.valid.size();
  std::vector<std::byte> plain(pixels * (2 * bands + 1));
  std::vector<uint16_t> plane(pixels), before(pixels, 0);
  for (uint32_t b = 0; b < bands; ++b) {
    for (size_t i = 0; i < pixels; ++i) {
      const float v = block.valid[i] ? block.values[i * bands + b] : 0.0f;
      if (!(v >= -32768.0f && v <= 32767.0f) || v != std::floor(v))
        throw fail(ErrorKind::input, "{}: has the number {}; only whole ones of 16 bits can be baked", path, v);
      const auto number = static_cast<uint16_t>(static_cast<int16_t>(v));
      plane[i] = static_cast<uint16_t>(number - before[i]);
      before[i] = number;
    }
    for (uint32_t y = 0; y < block.height; ++y)
      for (uint32_t x = 0; x < block.width; ++x) {
        const size_t i = size_t{y} * block.width + x;
        const uint16_t rest = zigzag(static_cast<uint16_t>(plane[i] - predicted(plane, block.width, x, y)));
        plain[b * pixels + i] = static_cast<std::byte>(rest);
        plain[(bands + b) * pixels + i] = static_cast<std::byte>(rest >> 8);
      }
  }
  std::memcpy(plain.data() + 2 * bands * pixels, block.valid.data(), pixels);
  uLongf size = compressBound(static_cast<uLong>(plain.size()));
  std::vector<std::byte> out(size);
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(plain.data()),
                static_cast<uLong>(plain.size()), Z_BEST_COMPRESSION) != Z_OK)
    throw fail(ErrorKind::failure, "{}: cannot be compressed", path);
  out.resize(size);
  return out;
}

/// `block` has its size; false where the bytes are not such a block.
bool decode(std::span<const std::byte> bytes, uint32_t bands, RasterBlock& block) {
  const size_t pixels = size_t{block.width} * block.height;
  std::vector<std::byte> plain(pixels * (2 * bands + 1));
  uLongf size = static_cast<uLongf>(plain.size());
  if (uncompress(reinterpret_cast<Bytef*>(plain.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                 static_cast<uLong>(bytes.size())) != Z_OK ||
      size != plain.size())
    return false;
  block.values.resize(pixels * bands);
  block.valid.resize(pixels);
  std::memcpy(block.valid.data(), plain.data() + 2 * bands * pixels, pixels);
  std::vector<uint16_t> plane(pixels), before(pixels, 0);
  for (uint32_t b = 0; b < bands; ++b)
    for (uint32_t y = 0; y < block.height; ++y)
      for (uint32_t x = 0; x < block.width; ++x) {
        const size_t i = size_t{y} * block.width + x;
        const auto low = static_cast<uint16_t>(plain[b * pixels + i]);
        const auto high = static_cast<uint16_t>(plain[(bands + b) * pixels + i]);
        const uint16_t rest = unzigzag(static_cast<uint16_t>(low | high << 8));
        plane[i] = static_cast<uint16_t>(rest + predicted(plane, block.width, x, y));
        before[i] = static_cast<uint16_t>(before[i] + plane[i]);
        block.values[i * bands + b] = static_cast<float>(static_cast<int16_t>(before[i]));
      }
  return true;
}

class BakedRaster final : public Raster {
 public:
  BakedRaster(RasterInfo info, std::string file) : info_(std::move(info)), file_(std::move(file)) {
    columns_ = (info_.width + kSide - 1) / kSide;
  }
  const RasterInfo& info() const override { return info_; }
  uint32_t reductions() const override { return reduction_count(info_.width, info_.height); }
  Result<RasterBlock> read_block(uint32_t reduction, uint32_t bx, uint32_t by) const override {
    const auto window = block_window(info_, reduction, bx, by);
    if (!window)
      return Result<RasterBlock>::failed(
          fmt::format("{}: has no block ({}, {}) at reduction {}", info_.path, bx, by, reduction));
    const uint32_t bands = info_.bands;
    BlockAverager averager(window->src_width, window->src_height, bands, window->factor);
    std::vector<float> values(size_t{window->src_width} * kSide * bands);
    std::vector<uint8_t> valid(size_t{window->src_width} * kSide);
    for (uint32_t y = 0; y < window->src_height; y += kSide) {
      uint32_t rows = 0;
      for (uint32_t x = 0; x < window->src_width; x += kSide) {
        const std::optional<RasterBlock> block = stored((window->x0 + x) / kSide, (window->y0 + y) / kSide);
        if (!block) return Result<RasterBlock>::failed(fmt::format("{}: is damaged", info_.path));
        rows = block->height;
        for (uint32_t row = 0; row < rows; ++row) {
          const size_t target = size_t{row} * window->src_width + x, source = size_t{row} * block->width;
          std::copy_n(block->valid.data() + source, block->width, valid.data() + target);
          std::copy_n(block->values.data() + source * bands, size_t{block->width} * bands,
                      values.data() + target * bands);
        }
      }
      for (uint32_t row = 0; row < rows; ++row)
        averager.add_row(
            std::span(values).subspan(size_t{row} * window->src_width * bands, size_t{window->src_width} * bands),
            std::span(valid).subspan(size_t{row} * window->src_width, window->src_width));
    }
    return std::move(averager).finish();
  }

 private:
  std::optional<RasterBlock> stored(uint32_t bx, uint32_t by) const {
    Place place;
    std::memcpy(&place, file_.data() + sizeof(Header) + (size_t{by} * columns_ + bx) * sizeof(Place), sizeof(Place));
    RasterBlock block{.width = std::min(kSide, info_.width - bx * kSide),
                      .height = std::min(kSide, info_.height - by * kSide),
                      .values = {},
                      .valid = {}};
    if (place.first > file_.size() || place.bytes > file_.size() - place.first) return std::nullopt;
    const auto bytes = std::as_bytes(std::span(file_)).subspan(place.first, place.bytes);
    if (!decode(bytes, info_.bands, block)) return std::nullopt;
    return block;
  }
  RasterInfo info_;
  std::string file_;
  uint32_t columns_ = 1;
};

}  // namespace

void bake_raster(const Raster& raster, const std::filesystem::path& file) {
  const RasterInfo& info = raster.info();
  NEPHO_ASSERT(info.bands >= 1 && info.bands <= kMostBands);
  Header header;
  header.width = info.width;
  header.height = info.height;
  header.bands = info.bands;
  header.wraps = info.wraps ? 1 : 0;
  header.ellipsoid = info.vertical == VerticalDatum::ellipsoid ? 1 : 0;
  header.west_deg = info.bounds.west_deg;
  header.south_deg = info.bounds.south_deg;
  header.east_deg = info.bounds.east_deg;
  header.north_deg = info.bounds.north_deg;
  header.oversampling = info.oversampling;
  header.opacity = info.opacity;
  const uint32_t columns = (info.width + kSide - 1) / kSide, rows = (info.height + kSide - 1) / kSide;
  std::vector<Place> places(size_t{columns} * rows);
  std::vector<std::byte> out(sizeof(Header) + places.size() * sizeof(Place));
  for (size_t i = 0; i < places.size(); ++i) {
    const auto bx = static_cast<uint32_t>(i % columns), by = static_cast<uint32_t>(i / columns);
    const RasterBlock block = raster.read_block(0, bx, by).take_or_throw(ErrorKind::input);
    const std::vector<std::byte> bytes = encode(block, info.bands, info.path);
    places[i] = {out.size(), bytes.size()};
    out.insert(out.end(), bytes.begin(), bytes.end());
  }
  std::memcpy(out.data() + sizeof(Header), places.data(), places.size() * sizeof(Place));
  std::memcpy(out.data(), &header, sizeof(Header));
  header.checksum = checksum_of(out.data() + kChecked, out.size() - kChecked);
  std::memcpy(out.data(), &header, sizeof(Header));
  write_whole_file(file, [&](const std::filesystem::path& temporary) {
    write_text_file(temporary, {reinterpret_cast<const char*>(out.data()), out.size()});
  });
}

std::shared_ptr<Raster> open_baked_raster(const std::filesystem::path& file) {
  std::string bytes = read_text_file(file);
  Header header;
  const auto refuse = [&](const char* why) { return fail(ErrorKind::input, "{}: {}", file.string(), why); };
  if (bytes.size() < sizeof(Header)) throw refuse("is no baked raster: shorter than its header");
  std::memcpy(&header, bytes.data(), sizeof(Header));
  if (std::memcmp(header.magic, Header{}.magic, sizeof(header.magic)) != 0)
    throw refuse("is no baked raster of this version");
  if (header.checksum !=
      checksum_of(reinterpret_cast<const std::byte*>(bytes.data()) + kChecked, bytes.size() - kChecked))
    throw refuse("is cut off or damaged");
  const uint64_t blocks =
      (uint64_t{header.width} + kSide - 1) / kSide * ((uint64_t{header.height} + kSide - 1) / kSide);
  if (blocks == 0 || header.bands == 0 || header.bands > kMostBands ||
      bytes.size() < sizeof(Header) + blocks * sizeof(Place))
    throw refuse("is cut off or damaged");
  RasterInfo info;
  info.path = file.string();
  info.width = header.width;
  info.height = header.height;
  info.bands = header.bands;
  info.bounds = {header.west_deg, header.south_deg, header.east_deg, header.north_deg};
  info.wraps = header.wraps != 0;
  info.oversampling = header.oversampling;
  info.vertical = header.ellipsoid ? VerticalDatum::ellipsoid : VerticalDatum::egm96;
  info.opacity = header.opacity;
  info.fingerprint = fmt::format("baked {:016x}", header.checksum);
  return std::make_shared<BakedRaster>(std::move(info), std::move(bytes));
}

}  // namespace nepho
