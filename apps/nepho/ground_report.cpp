#include "nepho/ground_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "terrain/raster_window.h"

namespace nepho {

namespace {

std::vector<SourceStats> all_stats(const Terrain& terrain) {
  std::vector<SourceStats> all = terrain.heights().source_stats();
  const std::vector<SourceStats> imagery = terrain.imagery().source_stats();
  all.insert(all.end(), imagery.begin(), imagery.end());
  return all;
}

}  // namespace

std::vector<RasterInfo> named_rasters(const TerrainSources& sources, const Scene& scene) {
  std::vector<RasterInfo> named;
  const auto add = [&](const std::shared_ptr<Raster>& raster, const auto& entries) {
    if (std::any_of(entries.begin(), entries.end(), [&](const auto& e) { return e.path == raster->info().path; }))
      named.push_back(raster->info());
  };
  for (const auto& raster : sources.elevation) add(raster, scene.terrain.elevation);
  for (const auto& raster : sources.imagery) add(raster, scene.imagery.files);
  return named;
}

std::vector<std::string> out_of_view(const std::vector<RasterInfo>& rasters, const Terrain& terrain) {
  std::vector<std::string> lines;
  if (terrain.selected().empty()) return lines;  // a view of the sky
  const auto in_view = [&](const RasterInfo& info) {
    return std::any_of(terrain.selected().begin(), terrain.selected().end(),
                       [&](const SelectedTile& s) { return overlaps(info.bounds, tile_bounds(s.tile)); });
  };
  std::set<std::string> seen, told;  // a folder is several rasters of one path
  for (const RasterInfo& info : rasters)
    if (!seen.contains(info.path) && in_view(info)) seen.insert(info.path);
  for (const RasterInfo& info : rasters) {
    if (seen.contains(info.path) || !told.insert(info.path).second) continue;
    const LonLatBounds& b = info.bounds;
    lines.push_back(
        fmt::format("{}: none of it is in view; it covers longitude {:.4g} to {:.4g}, latitude {:.4g} to "
                    "{:.4g}",
                    info.path, b.west_deg, b.east_deg, b.south_deg, b.north_deg));
  }
  return lines;
}

std::string first_failure(const Terrain& terrain) {
  for (const SourceStats& s : all_stats(terrain))
    if (s.failed > 0) return s.failure;
  return {};
}

nlohmann::ordered_json ground_report(const Terrain& terrain) {
  SourceStats sum;
  nlohmann::ordered_json sources = nlohmann::ordered_json::array();
  for (const SourceStats& s : all_stats(terrain)) {
    sum.read += s.read;
    sum.averaged += s.averaged;
    sum.from_disk += s.from_disk;
    sum.retried += s.retried;
    sum.failed += s.failed;
    sources.push_back({{"path", s.path},
                       {"blocks_read", s.read},
                       {"blocks_averaged", s.averaged},
                       {"blocks_from_disk", s.from_disk},
                       {"blocks_retried", s.retried},
                       {"blocks_failed", s.failed},
                       {"given_up", s.given_up}});
    if (!s.failure.empty()) sources.back()["failure"] = s.failure;
  }
  const Terrain::Stats& stats = terrain.stats();
  nlohmann::ordered_json j = {
      {"tiles_drawn", stats.tiles_drawn}, {"tiles_missing", stats.tiles_missing}, {"tiles_loaded", stats.tiles_loaded},
      {"triangles", stats.triangles},     {"deepest_level", stats.deepest_level}, {"select_ms", stats.select_ms},
      {"build_ms", stats.build_ms},       {"upload_ms", stats.upload_ms},         {"blocks_read", sum.read},
      {"blocks_averaged", sum.averaged},  {"blocks_from_disk", sum.from_disk},    {"blocks_retried", sum.retried},
      {"blocks_failed", sum.failed},      {"gpu_bytes", stats.gpu_bytes}};
  if (const HostBudget* memory = terrain.caches().memory.get()) {
    j["host_bytes"] = memory->bytes();
    j["host_peak_bytes"] = memory->peak_bytes();
    j["host_budget_bytes"] = memory->limit_bytes();
    j["host_dropped"] = memory->dropped();
  }
  if (const BlockStore* disk = terrain.caches().disk.get()) {
    const BlockStore::Stats s = disk->stats();
    j["disk"] = {{"blocks_loaded", s.loaded},
                 {"blocks_saved", s.saved},
                 {"files_damaged", s.damaged},
                 {"files_removed", s.removed},
                 {"writing", s.writing}};
  }
  j["sources"] = sources;
  return j;
}

}  // namespace nepho
