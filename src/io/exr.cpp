#include "io/exr.h"

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfTestFile.h>
#include <ImfThreading.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>
#include <thread>

#include "base/error.h"
#include "base/files.h"

namespace nepho {
namespace fs = std::filesystem;

namespace {

/// OpenEXR's own file stream forgets what goes wrong when the last bytes are flushed; this one does not.
class CheckedStream final : public Imf::OStream {
 public:
  explicit CheckedStream(const fs::path& path) : Imf::OStream(path.c_str()), file_(std::fopen(path.c_str(), "wb")) {
    if (!file_) note();
  }
  ~CheckedStream() override {
    if (file_) std::fclose(file_);
  }
  CheckedStream(const CheckedStream&) = delete;
  CheckedStream& operator=(const CheckedStream&) = delete;

  void write(const char bytes[], int count) override {
    if (std::fwrite(bytes, 1, static_cast<size_t>(count), file_) != static_cast<size_t>(count)) note_and_throw();
  }
  uint64_t tellp() override { return static_cast<uint64_t>(ftello(file_)); }
  void seekp(uint64_t position) override {
    if (fseeko(file_, static_cast<off_t>(position), SEEK_SET) != 0) note_and_throw();
  }
  void close() {
    if (file_ && std::fclose(file_) != 0) note();
    file_ = nullptr;
  }
  bool good() const { return errno_ == 0; }
  std::string reason() const { return std::strerror(errno_); }

 private:
  void note() {
    if (errno_ == 0) errno_ = errno != 0 ? errno : EIO;
  }
  [[noreturn]] void note_and_throw() {
    note();
    throw std::runtime_error(reason());
  }
  std::FILE* file_ = nullptr;
  int errno_ = 0;
};

int exr_threads() {
  static const int count = [] {
    const int n = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 16u));
    Imf::setGlobalThreadCount(n);
    return n;
  }();
  return count;
}

/// glm stores the columns of a column-vector matrix one after the other, Imath the rows of its transpose: same bytes.
Imath::M44f to_imath(const glm::mat4& m) {
  Imath::M44f out;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) out[row][column] = m[row][column];
  return out;
}

glm::mat4 from_imath(const Imath::M44f& m) {
  glm::mat4 out(0.0f);
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) out[row][column] = m[row][column];
  return out;
}

Imf::Header make_header(const ImageBuffer& image, const ExrAttributes& a) {
  Imf::Header header(static_cast<int>(image.width), static_cast<int>(image.height));
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const ImageChannel& channel : image.channels) header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
  if (a.rec709) Imf::addChromaticities(header, Imf::Chromaticities());
  if (a.longitude_deg) Imf::addLongitude(header, *a.longitude_deg);
  if (a.latitude_deg) Imf::addLatitude(header, *a.latitude_deg);
  if (a.altitude_m) Imf::addAltitude(header, *a.altitude_m);
  if (a.cap_date) Imf::addCapDate(header, *a.cap_date);
  if (a.utc_offset_s) Imf::addUtcOffset(header, *a.utc_offset_s);
  if (a.world_to_camera) Imf::addWorldToCamera(header, to_imath(*a.world_to_camera));
  if (a.world_to_ndc) Imf::addWorldToNDC(header, to_imath(*a.world_to_ndc));
  if (a.white_luminance) Imf::addWhiteLuminance(header, *a.white_luminance);
  if (a.comments) Imf::addComments(header, *a.comments);
  for (const auto& [name, value] : a.strings) header.insert(name, Imf::StringAttribute(value));
  for (const auto& [name, value] : a.floats) header.insert(name, Imf::FloatAttribute(value));
  return header;
}

ExrAttributes read_attributes(const Imf::Header& header) {
  ExrAttributes a;
  a.rec709 = !Imf::hasChromaticities(header) || Imf::chromaticities(header) == Imf::Chromaticities();
  if (Imf::hasWorldToCamera(header)) a.world_to_camera = from_imath(Imf::worldToCamera(header));
  if (Imf::hasWorldToNDC(header)) a.world_to_ndc = from_imath(Imf::worldToNDC(header));
  const std::map<std::string, std::optional<float>*> known_floats = {{"longitude", &a.longitude_deg},
                                                                     {"latitude", &a.latitude_deg},
                                                                     {"altitude", &a.altitude_m},
                                                                     {"utcOffset", &a.utc_offset_s},
                                                                     {"whiteLuminance", &a.white_luminance}};
  const std::map<std::string, std::optional<std::string>*> known_strings = {{"capDate", &a.cap_date},
                                                                            {"comments", &a.comments}};
  // What every EXR has is not an attribute of ours.
  const auto is_layout = [](const std::string& n) {
    return n == "pixelAspectRatio" || n == "screenWindowWidth" || n == "type" || n == "name" || n == "view";
  };
  for (auto it = header.begin(); it != header.end(); ++it) {
    const std::string name = it.name();
    if (const auto* number = dynamic_cast<const Imf::FloatAttribute*>(&it.attribute())) {
      if (const auto known = known_floats.find(name); known != known_floats.end())
        *known->second = number->value();
      else if (!is_layout(name))
        a.floats[name] = number->value();
    } else if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute())) {
      if (const auto known = known_strings.find(name); known != known_strings.end())
        *known->second = text->value();
      else if (!is_layout(name))
        a.strings[name] = text->value();
    }
  }
  return a;
}

/// A damaged header can claim any size; no compression of EXR shrinks pixels by more than this.
constexpr uint64_t kLargestRatio = 4096;

ExrFile read_open_file(const fs::path& path, Imf::InputFile& file) {
  const Imf::Header& header = file.header();
  const Imath::Box2i window = header.dataWindow();
  const int64_t width = int64_t{window.max.x} - window.min.x + 1, height = int64_t{window.max.y} - window.min.y + 1;
  uint64_t channels = 0;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it, ++channels)
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1)
      throw fail(ErrorKind::input, "{}: channel '{}' is subsampled; write it at full size", path.string(), it.name());
  if (width <= 0 || height <= 0 ||
      static_cast<uint64_t>(width) >
          fs::file_size(path) * kLargestRatio / static_cast<uint64_t>(height) / (channels + 1))
    throw fail(ErrorKind::input, "{}: the header claims {} x {} pixels, more than the file can hold", path.string(),
               width, height);

  ExrFile out;
  out.attributes = read_attributes(header);
  out.image.width = static_cast<uint32_t>(width);
  out.image.height = static_cast<uint32_t>(height);
  Imf::FrameBuffer buffer;
  out.image.channels.reserve(channels);
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    ImageChannel& channel = out.image.channels.emplace_back();
    channel.name = it.name();
    channel.values.resize(static_cast<size_t>(width) * static_cast<size_t>(height));
    buffer.insert(it.name(), Imf::Slice::Make(Imf::FLOAT, channel.values.data(), window));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  return out;
}

}  // namespace

std::string exr_cap_date(const std::string& iso8601_utc) {
  std::string out = iso8601_utc.substr(0, 19);
  for (const size_t dash : {size_t{4}, size_t{7}})
    if (dash < out.size()) out[dash] = ':';
  if (out.size() > 10) out[10] = ' ';
  return out;
}

void write_exr(const fs::path& path, const ImageBuffer& image, const ExrAttributes& attributes) {
  constexpr uint32_t kLargestSide = 1u << 30;  // OpenEXR counts pixels of a row in int
  NEPHO_ASSERT(image.width > 0 && image.height > 0 && image.width < kLargestSide && image.height < kLargestSide);
  NEPHO_ASSERT(!image.channels.empty());
  Imf::FrameBuffer buffer;
  for (const ImageChannel& channel : image.channels) {
    NEPHO_ASSERT_OP(channel.values.size(), ==, size_t{image.width} * image.height);
    NEPHO_ASSERT(buffer.findSlice(channel.name) == nullptr);  // a name twice would lose one of them
    // OpenEXR reads from a frame buffer through the pointer type that it also writes through.
    char* const pixels = const_cast<char*>(reinterpret_cast<const char*>(channel.values.data()));
    buffer.insert(channel.name, Imf::Slice(Imf::FLOAT, pixels, sizeof(float), sizeof(float) * image.width));
  }
  write_whole_file(path, [&](const fs::path& temporary) {
    CheckedStream stream(temporary);
    std::string reason = stream.good() ? "" : stream.reason();
    if (stream.good()) {
      try {
        Imf::OutputFile file(stream, make_header(image, attributes), exr_threads());
        file.setFrameBuffer(buffer);
        file.writePixels(static_cast<int>(image.height));
      } catch (const std::exception& e) {
        reason = e.what();
      }
    }
    stream.close();  // after the file's destructor, which writes the table of line offsets
    if (!stream.good()) reason = stream.reason();
    if (!reason.empty()) throw fail(ErrorKind::failure, "{}: cannot be written ({})", path.string(), reason);
  });
}

ExrFile read_exr(const fs::path& path) {
  std::error_code ec;
  if (!fs::exists(path, ec)) throw fail(ErrorKind::input, "{}: no such file", path.string());
  bool tiled = false, deep = false;
  if (fs::is_directory(path, ec) || !Imf::isOpenExrFile(path.c_str(), tiled, deep))
    throw fail(ErrorKind::input, "{}: is not an OpenEXR file", path.string());
  if (deep) throw fail(ErrorKind::input, "{}: is a deep EXR; flatten it first", path.string());
  try {
    Imf::InputFile file(path.c_str(), exr_threads());
    return read_open_file(path, file);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw fail(ErrorKind::input, "{}: is too large to be held in memory", path.string());
  } catch (const std::exception& e) {
    std::string reason = e.what();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw fail(ErrorKind::input, "{}: is a damaged OpenEXR file ({})", path.string(), reason);
  }
}

}  // namespace nepho
