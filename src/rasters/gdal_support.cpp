#include "rasters/gdal_support.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <cpl_vsi.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <set>
#include <vector>

#include "base/error.h"
#include "base/files.h"

namespace nepho {

namespace {

/// GDAL's own cache of blocks would take a twentieth of the machine's memory, beside the host budget. Sequential
/// formats (JPEG, PNG) decode from the top for every row that has left it: it holds a picture of 8192 x 4096.
void bound_cache() {
  constexpr GIntBig kCacheBytes = 128 << 20;
  if (!CPLGetConfigOption("GDAL_CACHEMAX", nullptr)) GDALSetCacheMax64(kCacheBytes);
}

void set_default(const char* name, const char* value) {
  if (!CPLGetConfigOption(name, nullptr)) CPLSetConfigOption(name, value);
}

/// The bytes that end a file of a format that is decoded from its top only; empty for other formats.
std::string end_marker(const std::string& driver) {
  return driver == "JPEG" ? "\xff\xd9" : driver == "PNG" ? "IEND" : "";
}

bool ends_with_marker(const std::string& path, const std::string& marker) {
  VSILFILE* file = VSIFOpenL(path.c_str(), "rb");
  if (!file) return true;  // not a plain path: reading will tell
  constexpr vsi_l_offset kTail = 65536;
  VSIFSeekL(file, 0, SEEK_END);
  const vsi_l_offset size = VSIFTellL(file);
  VSIFSeekL(file, size > kTail ? size - kTail : 0, SEEK_SET);
  std::string tail(static_cast<size_t>(std::min(size, kTail)), '\0');
  tail.resize(VSIFReadL(tail.data(), 1, tail.size(), file));
  VSIFCloseL(file);
  return tail.find(marker) != std::string::npos;
}

bool first_and_last_pixel_readable(GDALDataset& dataset) {
  float pixel = 0.0f;
  const auto read = [&](int band, int x, int y) {
    return dataset.GetRasterBand(band)->RasterIO(GF_Read, x, y, 1, 1, &pixel, 1, 1, GDT_Float32, 0, 0, nullptr) ==
           CE_None;
  };
  return read(1, 0, 0) && read(dataset.GetRasterCount(), dataset.GetRasterXSize() - 1, dataset.GetRasterYSize() - 1);
}

std::string bracketed(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
  if (text.size() > 240) text = text.substr(0, 240) + "...";
  return text.empty() ? "" : " (" + text + ")";
}

std::string first_subdatasets(GDALDataset& dataset) {
  std::string names;
  char** const all = dataset.GetMetadata("SUBDATASETS");
  for (int i = 1; i <= 3; ++i) {
    const char* name = CSLFetchNameValue(all, CPLSPrintf("SUBDATASET_%d_NAME", i));
    if (name) names += (names.empty() ? "" : ", ") + std::string(name);
  }
  return names;
}

}  // namespace

void init_gdal() {
  static std::once_flag once;
  std::call_once(once, [] {
    set_default("GTIFF_REPORT_COMPD_CS", "YES");  // else GeoTIFF 1.0 loses its vertical datum
    set_default("VRT_SHARED_SOURCE", "NO");       // openings of a VRT serve different threads
    // Else GDAL keeps the tiles of services in a folder below wherever the program was started.
    if (const std::filesystem::path cache = cache_dir(); !cache.empty())
      set_default("GDAL_DEFAULT_WMS_CACHE_PATH", (cache / "services").c_str());
    GDALAllRegister();
    // What a call says after it was given up comes too late to be of use.
    CPLSetErrorHandler(CPLQuietErrorHandler);
    bound_cache();
  });
}

GdalMessages::GdalMessages() { CPLPushErrorHandlerEx(&GdalMessages::handle, this); }

GdalMessages::~GdalMessages() { CPLPopErrorHandler(); }

void CPL_STDCALL GdalMessages::handle(CPLErr level, CPLErrorNum, const char* text) {
  auto& self = *static_cast<GdalMessages*>(CPLGetErrorHandlerUserData());
  (level >= CE_Failure ? self.last_error_ : self.last_warning_) = text;
  if (self.all_.size() < 4096) self.all_ += text;
  for (const char* word : {"CRS", "crs", "SRS", "EPSG", "PROJ", "proj_"})
    if (std::strstr(text, word)) self.crs_ = text;
}

std::string GdalMessages::in_brackets() const { return bracketed(last_error_.empty() ? last_warning_ : last_error_); }

std::string GdalMessages::crs_complaint() const { return bracketed(crs_); }

bool GdalMessages::contains(const std::string& words) const { return all_.find(words) != std::string::npos; }

void refuse_pipes(const std::string& path) {
  VSIStatBufL stat;
  if (VSIStatL(path.c_str(), &stat) != 0 || VSI_ISREG(stat.st_mode) || VSI_ISDIR(stat.st_mode)) return;
  throw fail(ErrorKind::input, "{}: is a pipe or device; give a file", path);
}

void set_network_timeout(double seconds) {
  static std::mutex mutex;
  static std::set<std::string> ours;
  const std::lock_guard lock(mutex);
  const auto set = [&](const char* name, const std::string& value) {
    if (CPLGetConfigOption(name, nullptr) && !ours.contains(name)) return;
    ours.insert(name);
    CPLSetConfigOption(name, value.c_str());
  };
  set("GDAL_HTTP_TIMEOUT", fmt::format("{:.3f}", seconds));
  set("GDAL_HTTP_CONNECTTIMEOUT", fmt::format("{:.3f}", seconds));
  set("GDAL_HTTP_MAX_RETRY", "1");
  set("GDAL_HTTP_RETRY_DELAY", "0.5");
}

GDALDatasetUniquePtr open_dataset(const std::string& path, const GdalMessages& messages, const std::string& name) {
  init_gdal();
  VSIStatBufL stat;
  const bool on_disk = VSIStatL(path.c_str(), &stat) == 0;
  if (path.empty() || (!on_disk && path.find(':') == std::string::npos && path.find('<') == std::string::npos))
    throw fail(ErrorKind::input, "{}: no such file", name.empty() ? "(empty file name)" : name);
  if (on_disk && VSI_ISREG(stat.st_mode) && stat.st_size == 0)
    throw fail(ErrorKind::input, "{}: is an empty file", name);

  GDALDatasetUniquePtr dataset(
      GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR));
  if (!dataset && on_disk && VSI_ISDIR(stat.st_mode))
    throw fail(ErrorKind::input, "{}: is a folder, not a raster file", name);
  if (!dataset) throw fail(ErrorKind::input, "{}: is not a raster that GDAL can open{}", name, messages.in_brackets());
  if (dataset->GetRasterCount() == 0) {
    const std::string inside = first_subdatasets(*dataset);
    throw fail(ErrorKind::input, "{}: {}", name,
               inside.empty() ? "holds no raster bands" : "holds several rasters; name one of them: " + inside);
  }
  const std::string marker = end_marker(dataset->GetDriverName());
  if (marker.empty() ? !first_and_last_pixel_readable(*dataset) : !ends_with_marker(path, marker))
    throw fail(ErrorKind::input, "{}: is cut off or damaged, its pixels cannot be read{}", name,
               messages.in_brackets());
  return dataset;
}

}  // namespace nepho
