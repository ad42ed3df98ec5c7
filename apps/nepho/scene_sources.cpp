#include "nepho/scene_sources.h"

#include <algorithm>
#include <iterator>

#include "base/log.h"
#include "base/patient_caller.h"
#include "io/mapped_raster.h"
#include "terrain/cached_raster.h"
#include "terrain/source_reader.h"

namespace nepho {

namespace {

// The Blue Marble is stretched until forests are black and deserts glare. These bring its Amazon (sRGB 10 40 10) to an
// albedo near 0.03 0.04 0.02 and its Sahara (200 170 120) to 0.48 0.34 0.17, as MODIS has them.
constexpr float kBlueMarbleOffset = 0.02f, kBlueMarbleScale = 0.82f;

/// A stack from bottom to top.
template <typename Source>
std::vector<const Source*> in_order(const std::vector<Source>& stack) {
  std::vector<const Source*> sorted;
  for (const Source& source : stack) sorted.push_back(&source);
  std::ranges::stable_sort(sorted, {}, [](const Source* source) { return source->order; });
  return sorted;
}

using Rasters = std::vector<std::shared_ptr<Raster>>;

/// Opens rasters that may be damaged or not answer. `open` must own what it uses: it may outlive the call.
class Opening {
 public:
  /// `missing`: of what cannot be read later.
  Opening(double timeout_s, BadSource bad, SourceReader::Missing missing = SourceReader::Missing::left_out)
      : timeout_s_(timeout_s), bad_(bad), missing_(missing) {}
  /// What `path` is made of; empty: it was left out.
  template <typename F>
  Rasters parts(const std::string& path, F open) const {
    try {
      const PatientCaller caller(timeout_s_);
      std::optional<Rasters> rasters = caller.call(std::move(open));
      if (!rasters) throw fail(ErrorKind::input, "{}: does not answer within {:.3g} s", path, timeout_s_);
      for (std::shared_ptr<Raster>& raster : *rasters)
        raster = SourceReader::of(std::move(raster), timeout_s_, missing_);
      return std::move(*rasters);
    } catch (const Error& e) {
      if (bad_ == BadSource::error || e.kind() != ErrorKind::input) throw;
      log_warning("{}; left out (--strict makes this an error)", e.what());
      return {};
    }
  }
  /// The same of what must be one raster; null: it was left out.
  template <typename F>
  std::shared_ptr<Raster> operator()(const std::string& path, F open) const {
    Rasters one = parts(path, [open = std::move(open)] { return Rasters{open()}; });
    return one.empty() ? nullptr : std::move(one.front());
  }

 private:
  double timeout_s_;
  BadSource bad_;
  SourceReader::Missing missing_;
};

void append(Rasters& to, Rasters from) { std::ranges::move(from, std::back_inserter(to)); }

Rasters open_elevation(const std::shared_ptr<const RasterOpener>& opener, const Scene& scene, const DefaultEarth& earth,
                       BadSource bad, bool* has_default = nullptr) {
  const Opening opening(scene.terrain.source_timeout_s, bad);
  Rasters rasters;
  if (!earth.elevation.empty())
    rasters.push_back(opening(earth.elevation, [opener, earth] { return opener->open_elevation(earth.elevation); }));
  if (has_default) *has_default = !rasters.empty() && rasters[0];
  for (const ElevationSource* source : in_order(scene.terrain.elevation)) {
    RasterReading how{.opacity = source->opacity,
                      .vertical_scale = source->vertical_scale,
                      .encoding = source->encoding,
                      .min_zoom = source->min_zoom,
                      .max_zoom = source->max_zoom,
                      .timeout_s = scene.terrain.source_timeout_s};
    if (source->vertical_datum != "auto")
      how.vertical = source->vertical_datum == "ellipsoid" ? VerticalDatum::ellipsoid : VerticalDatum::egm96;
    append(rasters, opening.parts(source->path, [opener, path = source->path, how] {
      return opener->open_elevation_parts(path, how);
    }));
  }
  std::erase(rasters, nullptr);
  return rasters;
}

Rasters open_picture(const RasterOpener& opener, const ImagerySource& source, double timeout_s) {
  RasterReading how{.opacity = source.opacity,
                    .stretch = source.stretch.kind == Stretch::Kind::automatic,
                    .min_zoom = source.min_zoom,
                    .max_zoom = source.max_zoom,
                    .timeout_s = timeout_s};
  if (source.stretch.kind == Stretch::Kind::range) how.black_white = {source.stretch.low, source.stretch.high};
  Rasters rasters = opener.open_imagery_parts(source.path, how);
  if (source.gamma == 1.0 && source.albedo_scale == 1.0) return rasters;
  for (std::shared_ptr<Raster>& raster : rasters)
    raster = make_mapped_imagery(std::move(raster), albedo_curve(0.0f, static_cast<float>(source.albedo_scale),
                                                                 static_cast<float>(source.gamma)));
  return rasters;
}

std::shared_ptr<const Geoid> egm96() { return std::make_shared<const Geoid>(Geoid::egm96()); }

/// Without what lies below the clouds.
WeatherSources open_weather_files(const std::shared_ptr<const RasterOpener>& opener, const Scene& scene) {
  WeatherSources sources;
  const WeatherParams& weather = scene.clouds.weather;
  const Opening opening(scene.terrain.source_timeout_s, BadSource::error, SourceReader::Missing::fatal);
  if (weather.source == "raster")
    sources.weather = opening(weather.file, [opener, file = weather.file] { return opener->open_weather(file); });
  if (weather.source == "tile")
    sources.tile = opening(weather.file, [opener, file = weather.file] { return opener->open_tile(file); });
  return sources;
}

}  // namespace

TerrainSources open_terrain(const RasterAccess& rasters, const Scene& scene, BadSource bad) {
  TerrainSources sources;
  const std::shared_ptr<const RasterOpener>& opener = rasters.opener;
  if (!rasters.has_gdal()) bad = BadSource::error;  // not the files are bad
  const DefaultEarth earth = scene.terrain.default_earth ? rasters.find_default_earth() : DefaultEarth{};
  if (scene.terrain.default_earth) {
    std::vector<std::string> missing;
    if (earth.elevation.empty()) missing.push_back("ferret-datasets (elevation)");
    if (earth.imagery.empty()) missing.push_back("marble-qt-data (imagery)");
    if (earth.night.empty()) missing.push_back("xplanet-images (night lights)");
    if (!missing.empty() && !rasters.has_gdal())
      log_warning(
          "this build has no GDAL, and its folder no baked {}: there the ground is bare and at sea level; "
          "./nepho package makes a folder with the Earth",
          missing.size() == 3 ? "Earth" : "elevation, imagery or night lights");
    else if (!missing.empty())
      log_warning(
          "part of the default Earth is not installed: {}; install with apt-get install --no-install-recommends",
          fmt::join(missing, ", "));
  }
  const Opening opening(scene.terrain.source_timeout_s, bad);
  if (!earth.imagery.empty())
    sources.imagery.push_back(opening(earth.imagery, [opener, earth] {
      return make_mapped_imagery(opener->open_imagery(earth.imagery),
                                 albedo_curve(kBlueMarbleOffset, kBlueMarbleScale));
    }));
  if (!earth.night.empty())
    sources.night_lights = opening(earth.night, [opener, earth] { return opener->open_imagery(earth.night); });
  // After the default Earth: while GDAL waits for a file that hangs it may open no other.
  sources.elevation = open_elevation(opener, scene, earth, bad, &sources.has_default);
  for (const ImagerySource* source : in_order(scene.imagery.files))
    append(sources.imagery,
           opening.parts(source->path, [opener, picture = *source, timeout_s = scene.terrain.source_timeout_s] {
             return open_picture(*opener, picture, timeout_s);
           }));
  std::erase(sources.imagery, nullptr);
  if (!scene.terrain.water_mask.empty())
    sources.water_mask = opening(scene.terrain.water_mask,
                                 [opener, path = scene.terrain.water_mask, timeout_s = scene.terrain.source_timeout_s] {
                                   return opener->open_imagery(path, {.timeout_s = timeout_s});
                                 });
  sources.caches = make_raster_caches(scene.terrain);
  sources.geoid = egm96();
  sources.bare_albedo = scene.imagery.bare_albedo;
  return sources;
}

SkySources open_sky(const RasterAccess& rasters, const Scene& scene) {
  SkySources sources;
  const DefaultEarth earth = rasters.find_default_earth();
  if ((scene.night_sky.moon && earth.moon.empty()) || (scene.night_sky.stars && earth.stars.empty()))
    log_warning("{}", rasters.has_gdal()
                          ? "marble-qt-data is not installed: the moon is plain grey and there are no stars; install "
                            "it with apt-get install --no-install-recommends marble-qt-data"
                          : "this build has no GDAL, and its folder no baked moon and stars: the moon is plain grey "
                            "and there are no stars");
  if (scene.night_sky.moon && !earth.moon.empty())
    sources.moon_texture = Opening(scene.terrain.source_timeout_s, BadSource::warning)(
        earth.moon, [opener = rasters.opener, earth] { return opener->open_imagery(earth.moon); });
  if (scene.night_sky.stars && !earth.stars.empty()) sources.stars = read_star_catalog(earth.stars);
  return sources;
}

WeatherSources open_weather(const RasterAccess& rasters, const Scene& scene, const TerrainSources& terrain) {
  WeatherSources sources = open_weather_files(rasters.opener, scene);
  // The scene's own may be large or fail; the default Earth is neither.
  for (size_t i = 0; i < terrain.elevation.size(); ++i)
    sources.elevation.push_back(i == 0 && terrain.has_default
                                    ? terrain.elevation[i]
                                    : make_cached_raster(terrain.elevation[i], terrain.caches));
  sources.geoid = terrain.geoid;
  return sources;
}

WeatherSources open_weather(const RasterAccess& rasters, const Scene& scene) {
  WeatherSources sources = open_weather_files(rasters.opener, scene);
  sources.elevation =
      open_elevation(rasters.opener, scene, scene.terrain.default_earth ? rasters.find_default_earth() : DefaultEarth{},
                     BadSource::error);
  sources.geoid = egm96();
  return sources;
}

}  // namespace nepho
