#include "rasters/raster_folder.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal_utils.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <tuple>

#include "base/error.h"
#include "base/log.h"
#include "rasters/raster_clusters.h"

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
  bool degrees = false;
  std::string type, meaning, crs;
  std::string common() const { return type + " " + meaning + " " + crs; }
};

/// A raster of the folder.
struct Found {
  std::string file;
  Kind kind;
  std::optional<ClusterTile> place;  // none: rotated, upside down, or placed by points; no matter for a mosaic
};

/// None: no raster, or one that nothing places.
std::optional<Found> look_at(const std::string& file) {
  const GdalMessages quiet;
  const GDALDatasetUniquePtr dataset(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!dataset || dataset->GetRasterCount() == 0) return std::nullopt;
  Found found{.file = file,
              .kind = {.bands = dataset->GetRasterCount(),
                       .palette = dataset->GetRasterBand(1)->GetColorTable() != nullptr,
                       .type = GDALGetDataTypeName(dataset->GetRasterBand(1)->GetRasterDataType()),
                       .meaning = GDALGetColorInterpretationName(dataset->GetRasterBand(1)->GetColorInterpretation()),
                       .crs = {}},
              .place = {}};
  const OGRSpatialReference* srs = dataset->GetSpatialRef();
  if (srs) {
    char* text = nullptr;
    srs->exportToWkt(&text);
    found.kind.crs = text ? text : "";
    CPLFree(text);
  }
  found.kind.degrees = !srs || srs->IsGeographic();
  std::array<double, 6> g{};
  if (dataset->GetGeoTransform(g.data()) != CE_None)
    return dataset->GetGCPCount() > 0 || dataset->GetMetadata("RPC") || dataset->GetMetadata("GEOLOCATION")
               ? std::optional(found)
               : std::nullopt;
  const int width = dataset->GetRasterXSize(), height = dataset->GetRasterYSize();
  if (g[2] == 0.0 && g[4] == 0.0 && g[1] > 0.0 && g[5] < 0.0)
    found.place = ClusterTile{g[0], g[3] + g[5] * height, g[0] + g[1] * width, g[3], g[1], -g[5]};
  return found;
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

/// The files of a folder that can be used, and how many it has.
std::vector<Found> usable_files(const std::string& folder, bool elevation) {
  std::vector<std::string> files, skipped;
  list_files(folder, 0, files);
  using Look = std::tuple<int, bool, std::string>;
  // Heights of all types can be put together.
  const auto look_of = [&](const Kind& kind) { return Look(kind.bands, kind.palette, elevation ? "" : kind.type); };
  std::map<Look, size_t> counts;
  std::vector<Found> rasters;
  for (const std::string& file : files) {
    if (std::optional<Found> found = look_at(file)) {
      ++counts[look_of(found->kind)];
      rasters.push_back(std::move(*found));
    } else {
      skipped.push_back(file);
    }
  }
  if (rasters.empty()) throw fail(ErrorKind::input, "{}: is a folder without rasters ({} files)", folder, files.size());
  const auto most = std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; })->first;
  for (const Found& raster : rasters)
    if (look_of(raster.kind) != most) skipped.push_back(raster.file);
  std::erase_if(rasters, [&](const Found& raster) { return look_of(raster.kind) != most; });
  if (!skipped.empty())
    log_warning("{}: {} of {} files skipped, as they are no rasters, have no place or have other bands: {}{}", folder,
                skipped.size(), files.size(), skipped.front().substr(folder.size() + 1),
                skipped.size() > 1 ? ", ..." : "");
  return rasters;
}

}  // namespace

std::vector<RasterMosaic> mosaics_of_folder(const std::string& folder, bool elevation, const GdalMessages& messages) {
  const std::vector<Found> rasters = usable_files(folder, elevation);
  std::vector<std::vector<size_t>> parts;             // indices of `rasters`
  std::map<std::string, std::vector<size_t>> groups;  // that GDAL can put together
  for (size_t i = 0; i < rasters.size(); ++i) {
    if (rasters[i].place)
      groups[rasters[i].kind.common()].push_back(i);
    else
      parts.push_back({i});
  }
  for (const auto& [common, members] : groups) {
    std::vector<ClusterTile> tiles;
    for (const size_t i : members) tiles.push_back(*rasters[i].place);
    for (std::vector<size_t>& cluster : cluster_tiles(tiles, rasters[members[0]].kind.degrees ? 360.0 : 0.0)) {
      for (size_t& i : cluster) i = members[i];
      parts.push_back(std::move(cluster));
    }
  }
  // By the last name: where two parts overlap, later ones lie over earlier ones.
  std::ranges::sort(parts, {}, [](const std::vector<size_t>& part) { return part.back(); });
  std::vector<RasterMosaic> mosaics;
  for (const std::vector<size_t>& part : parts) {
    RasterMosaic mosaic;
    for (const size_t i : part) mosaic.files.push_back(rasters[i].file);
    mosaic.name = part.size() == 1 ? mosaic.files[0] : put_together(mosaic.files, folder, elevation, messages);
    mosaics.push_back(std::move(mosaic));
  }
  return mosaics;
}

}  // namespace nepho
