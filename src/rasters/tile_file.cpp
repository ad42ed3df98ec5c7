#include "rasters/tile_file.h"

#include <cpl_http.h>
#include <cpl_vsi.h>

#include <atomic>

#include "base/error.h"
#include "rasters/tile_names.h"

namespace nepho {

GDALDatasetUniquePtr open_tile_file(const std::string& name, bool& failed) {
  constexpr unsigned kFlags = GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR;
  failed = false;
  GDALDatasetUniquePtr tile;
  if (!is_url(name)) {
    VSIStatBufL stat;
    if (VSIStatL(name.c_str(), &stat) != 0 || stat.st_size == 0 || VSI_ISDIR(stat.st_mode)) return tile;
    tile.reset(GDALDataset::Open(name.c_str(), kFlags));
    failed = !tile;
    return tile;
  }
  // What GDAL_HTTP_TIMEOUT and its kin say is honoured by CPLHTTPFetch.
  CPLHTTPResult* const result = CPLHTTPFetch(name.c_str(), nullptr);
  const std::string problem = result && result->pszErrBuf ? result->pszErrBuf : "";
  // "Not found", "gone"; stores answer 403 for what is not there when listing is not allowed.
  const bool missing = contains(problem, "HTTP error code : 404") || contains(problem, "HTTP error code : 410") ||
                       contains(problem, "HTTP error code : 403");
  if (missing || (result && problem.empty() && result->nStatus == 0 && result->nDataLen == 0)) {
    CPLHTTPDestroyResult(result);
    return tile;
  }
  if (!result || !problem.empty() || result->nStatus != 0) {
    failed = true;
    CPLHTTPDestroyResult(result);
    return tile;
  }
  static std::atomic<uint64_t> number{0};
  const std::string in_memory = fmt::format("/vsimem/nepho_tile_{}", number++);
  // Decoded in one go by the caller, through a copy that the dataset owns.
  VSIFCloseL(
      VSIFileFromMemBuffer(in_memory.c_str(), result->pabyData, static_cast<vsi_l_offset>(result->nDataLen), FALSE));
  GDALDatasetUniquePtr fetched(GDALDataset::Open(in_memory.c_str(), kFlags));
  if (fetched)
    tile.reset(GetGDALDriverManager()->GetDriverByName("MEM")->CreateCopy("", fetched.get(), FALSE, nullptr, nullptr,
                                                                          nullptr));
  fetched.reset();
  VSIUnlink(in_memory.c_str());
  CPLHTTPDestroyResult(result);
  failed = !tile;
  return tile;
}

}  // namespace nepho
