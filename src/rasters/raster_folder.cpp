#include "rasters/raster_folder.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal_utils.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <tuple>

#include "base/error.h"
#include "base/log.h"
#include "rasters/georeference.h"

namespace nepho {

namespace {

constexpr int kDeepestFolder = 4;
constexpr size_t kMostFiles = 100000;

/// Files that belong to a raster beside them.
bool is_companion(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* end : {".ovr", ".msk", ".aux.xml", ".tfw", ".jgw", ".pgw", ".wld", ".prj", ".md5", ".hdr", ".rrd"})
    if (name.ends_with(end)) return true;
  return name.starts_with('.');
}

void list_files(const std::string& folder, int depth, std::vector<std::string>& files) {
  char** const names = VSIReadDir(folder.c_str());
  std::vector<std::string> sorted;
  for (char** name = names; name && *name; ++name) sorted.emplace_back(*name);
  CSLDestroy(names);
  std::sort(sorted.begin(), sorted.end());
  for (const std::string& name : sorted) {
    if (name == "." || name == ".." || is_companion(name) || files.size() >= kMostFiles) continue;
    const std::string path = folder + "/" + name;
    VSIStatBufL stat;
    if (VSIStatL(path.c_str(), &stat) != 0) continue;
    if (VSI_ISDIR(stat.st_mode)) {
      if (depth < kDeepestFolder) list_files(path, depth + 1, files);
    } else if (VSI_ISREG(stat.st_mode)) {
      files.push_back(path);
    }
  }
}

/// What has to agree for files to become one dataset as they are.
struct Kind {
  int bands = 0;
  bool palette = false;
  std::string type, meaning, crs;
  auto operator<=>(const Kind&) const = default;
};

std::optional<Kind> kind_of(const std::string& file) {
  const GdalMessages quiet;
  const GDALDatasetUniquePtr dataset(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!dataset || dataset->GetRasterCount() == 0) return std::nullopt;
  Kind kind{.bands = dataset->GetRasterCount(),
            .palette = dataset->GetRasterBand(1)->GetColorTable() != nullptr,
            .type = GDALGetDataTypeName(dataset->GetRasterBand(1)->GetRasterDataType()),
            .meaning = GDALGetColorInterpretationName(dataset->GetRasterBand(1)->GetColorInterpretation()),
            .crs = {}};
  if (const OGRSpatialReference* srs = dataset->GetSpatialRef()) {
    char* text = nullptr;
    srs->exportToWkt(&text);
    kind.crs = text ? text : "";
    CPLFree(text);
  }
  return kind;
}

std::string in_memory_name() {
  static std::atomic<uint64_t> number{0};
  return fmt::format("/vsimem/nepho_mosaic_{}.vrt", number++);
}

/// A VRT of files of one kind; its name in memory.
std::string put_together(const std::vector<std::string>& files, const std::string& folder, bool elevation,
                         const GdalMessages& messages) {
  bool bare = false;  // without nodata, alpha or mask, gaps would read as numbers
  {
    const GDALDatasetUniquePtr first(GDALDataset::Open(files.front().c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
    bare = first && first->GetRasterBand(1)->GetMaskFlags() == GMF_ALL_VALID;
  }
  CPLStringList names, args;
  for (const std::string& file : files) names.AddString(file.c_str());
  for (const char* word : {"-resolution", "highest", "-r", "bilinear", "-q"}) args.AddString(word);
  if (bare) args.AddString("-addalpha");
  std::unique_ptr<GDALBuildVRTOptions, decltype(&GDALBuildVRTOptionsFree)> options(
      GDALBuildVRTOptionsNew(args.List(), nullptr), &GDALBuildVRTOptionsFree);
  const std::string name = in_memory_name();
  int misuse = FALSE;
  const GDALDatasetUniquePtr mosaic(GDALDataset::FromHandle(
      GDALBuildVRT(name.c_str(), names.Count(), nullptr, names.List(), options.get(), &misuse)));
  if (!mosaic) throw fail(ErrorKind::input, "{}: its rasters cannot be put together{}", folder, messages.in_brackets());
  // GDAL puts only bands of one meaning together; some formats of elevation name none.
  if (elevation) mosaic->GetRasterBand(1)->SetColorInterpretation(GCI_GrayIndex);
  if (messages.contains("kipping"))
    log_warning("{}: some of its rasters cannot be put together with the others{}", folder, messages.in_brackets());
  return name;
}

/// The same warped to longitude and latitude; heights become floating-point numbers, NaN where there are none.
std::string on_lon_lat(const std::string& vrt, bool elevation, const std::string& folder,
                       const GdalMessages& messages) {
  const GDALDatasetUniquePtr dataset(GDALDataset::Open(vrt.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!dataset)
    throw fail(ErrorKind::input, "{}: its rasters cannot be put together{}", folder, messages.in_brackets());
  native_grid(*dataset, folder, messages);  // throws where nothing says where it lies
  const double alpha_max = dataset->GetRasterBand(1)->GetRasterDataType() == GDT_Byte ? 255.0 : 65535.0;
  const WarpPlan plan = plan_warp(*dataset, folder, elevation, alpha_max, messages);
  const std::string name = in_memory_name();
  warp(*dataset, plan, plan.levels.front(), folder, messages, name);
  return name;
}

}  // namespace

RasterMosaic mosaic_of_folder(const std::string& folder, bool elevation, const GdalMessages& messages) {
  std::vector<std::string> files, skipped;
  list_files(folder, 0, files);
  using Look = std::tuple<int, bool, std::string>;
  // Heights of all types can be put together.
  const auto look_of = [&](const Kind& kind) { return Look(kind.bands, kind.palette, elevation ? "" : kind.type); };
  std::map<Look, size_t> counts;
  std::vector<std::pair<std::string, Kind>> rasters;
  for (const std::string& file : files) {
    if (const std::optional<Kind> kind = kind_of(file)) {
      ++counts[look_of(*kind)];
      rasters.emplace_back(file, *kind);
    } else {
      skipped.push_back(file);
    }
  }
  if (rasters.empty()) throw fail(ErrorKind::input, "{}: is a folder without rasters ({} files)", folder, files.size());
  const auto most = std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; })->first;
  RasterMosaic mosaic;
  std::vector<std::pair<std::string, std::vector<std::string>>>
      groups;  // that GDAL can put together, in order of first use
  for (const auto& [file, kind] : rasters) {
    if (look_of(kind) != most) {
      skipped.push_back(file);
      continue;
    }
    mosaic.files.push_back(file);
    const std::string common = kind.type + " " + kind.meaning + " " + kind.crs;
    auto group = std::ranges::find(groups, common, [](const auto& g) { return g.first; });
    if (group == groups.end()) group = groups.insert(groups.end(), {common, {}});
    group->second.push_back(file);
  }
  if (!skipped.empty())
    log_warning("{}: {} of {} files skipped, as they are no rasters or have other bands: {}{}", folder, skipped.size(),
                files.size(), skipped.front().substr(folder.size() + 1), skipped.size() > 1 ? ", ..." : "");

  std::vector<std::string> parts;
  for (const auto& [common, members] : groups) parts.push_back(put_together(members, folder, elevation, messages));
  if (parts.size() > 1) {
    for (std::string& part : parts) part = on_lon_lat(part, elevation, folder, messages);
    parts = {put_together(parts, folder, elevation, messages)};
  }
  mosaic.name = parts[0];
  return mosaic;
}

}  // namespace nepho
