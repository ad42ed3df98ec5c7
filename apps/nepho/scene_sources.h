#pragma once
#include "nepho/raster_access.h"
#include "render/night_sky.h"
#include "scene/scene.h"
#include "terrain/terrain.h"
#include "weather/weather_map.h"

namespace nepho {

// Opens the rasters of a scene and of the default Earth. Each throws Error(input) for a file that is not what it should
// be; part of the default Earth that is not installed is warned about.

/// What to do with a raster of the ground that cannot be used, or does not answer within terrain.source_timeout_s.
enum class BadSource {
  error,    ///< throw Error(input)
  warning,  ///< leave it out, with one warning
};
TerrainSources open_terrain(const RasterAccess& rasters, const Scene& scene, BadSource bad = BadSource::error);
SkySources open_sky(const RasterAccess& rasters, const Scene& scene);
/// The weather's own files; elevation and geoid are those of the ground that is drawn.
WeatherSources open_weather(const RasterAccess& rasters, const Scene& scene, const TerrainSources& terrain);
/// The same where no ground is drawn, for probes.
WeatherSources open_weather(const RasterAccess& rasters, const Scene& scene);

}  // namespace nepho
