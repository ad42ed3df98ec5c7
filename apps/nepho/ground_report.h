#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "terrain/terrain.h"

namespace nepho {

/// The rasters that a scene names, as they were opened: what is left of TerrainSources when the terrain has them.
std::vector<RasterInfo> named_rasters(const TerrainSources& sources, const Scene& scene);

/// One line for each of these rasters that lies nowhere on the tiles that were drawn.
std::vector<std::string> out_of_view(const std::vector<RasterInfo>& rasters, const Terrain& terrain);

/// The first failure of a raster in words; empty when all blocks could be read.
std::string first_failure(const Terrain& terrain);

/// What was read, and what the caches hold: the member `terrain` of --timings.
nlohmann::ordered_json ground_report(const Terrain& terrain);

}  // namespace nepho
