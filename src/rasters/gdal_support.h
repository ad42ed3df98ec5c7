#pragma once
// Inside src/rasters only: nothing of GDAL leaves this folder.
#include <cpl_error.h>
#include <gdal_priv.h>

#include <string>

namespace nepho {

/// Registers GDAL's drivers, once (4 ms), and makes it report vertical CRSs.
void init_gdal();

/// While it lives, what GDAL says on this thread is kept here instead of going to standard error.
class GdalMessages {
 public:
  GdalMessages();
  ~GdalMessages();
  GdalMessages(const GdalMessages&) = delete;
  GdalMessages& operator=(const GdalMessages&) = delete;
  /// " (what GDAL said)" on one line: the last error, else the last warning, else nothing.
  std::string in_brackets() const;
  /// The same for what GDAL or PROJ said about a CRS only; empty when they did not complain of one.
  std::string crs_complaint() const;
  bool has_error() const { return !last_error_.empty(); }
  bool contains(const std::string& words) const;

 private:
  static void CPL_STDCALL handle(CPLErr level, CPLErrorNum number, const char* text);
  std::string last_error_, last_warning_, crs_, all_;
};

/// Opens a raster for reading. Throws Error(input) with one line: missing, empty, a folder, cut off, not a raster, no
/// bands. The last pixel is read on the way (JPEG, PNG: the end marker
/// looked for), so that a file that was cut off is found now and not in mid-frame.
/// `name` is what messages call it.
GDALDatasetUniquePtr open_dataset(const std::string& path, const GdalMessages& messages, const std::string& name);

/// Throws Error(input) for a pipe or device, whose opening or reading could wait for ever.
void refuse_pipes(const std::string& path);

/// After this time a server that does not answer has failed, and one that says it is busy has been asked twice.
/// Settings of GDAL in the environment (GDAL_HTTP_TIMEOUT, ...) win.
void set_network_timeout(double seconds);

}  // namespace nepho
