#pragma once
#include "nepho/raster_access.h"
#include "render/night_sky.h"
#include "scene/scene.h"
#include "terrain/terrain.h"
#include "weather/weather_map.h"

namespace nepho {

// Opens the rasters of a scene and of the default Earth. Each throws Error(input) for a file that is not what it should
// be; part of the default Earth that is not installed is warned about.

TerrainSources open_terrain(const RasterAccess& rasters, const Scene& scene);
SkySources open_sky(const RasterAccess& rasters, const Scene& scene);
/// The weather's own files; elevation and geoid are those of the ground that is drawn.
WeatherSources open_weather(const RasterAccess& rasters, const Scene& scene, const TerrainSources& terrain);
/// The same where no ground is drawn, for probes.
WeatherSources open_weather(const RasterAccess& rasters, const Scene& scene);

}  // namespace nepho
