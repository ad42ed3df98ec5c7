#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene/atmosphere_params.h"
#include "scene/cloud_params.h"
#include "scene/shaft_params.h"
#include "scene/source_params.h"

namespace nepho {

/// A point to look at. Without a height: the ground there.
struct LookAt {
  double lat_deg = 0.0;
  double lon_deg = 0.0;
  std::optional<double> height_m;  ///< above the ellipsoid
  bool operator==(const LookAt&) const = default;
};

/// Where the picture is taken from. Degrees here, at the edge of the program; radians inside.
struct CameraParams {
  double lat_deg = 35.5106;        ///< geodetic, -90..90
  double lon_deg = 138.7546;       ///< -180..360
  std::optional<double> height_m;  ///< above the ellipsoid
  std::optional<double> agl_m;     ///< above the ground; with neither: 2 m above the ground
  double heading_deg = 0.0;        ///< clockwise from north
  double pitch_deg = 0.0;          ///< 0 the horizon, -90 straight down
  double roll_deg = 0.0;           ///< clockwise as seen from behind the camera
  std::optional<LookAt> look_at;   ///< overrides heading and pitch
  double fov_deg = 45.0;           ///< vertical, (0, 180)
  bool allow_underground = false;  ///< keep a camera that is under the ground there; false: lifted to 2 m above it
  bool operator==(const CameraParams&) const = default;
};

struct TerrainParams {
  std::vector<ElevationSource> elevation;  ///< rasters over the default Earth, later over earlier
  bool default_earth = true;               ///< elevation and imagery from Debian packages where they are installed
  double screen_error_px = 1.0;            ///< level of detail: largest geometric error on screen, px, > 0
  bool shadows = true;                     ///< mountains shade other ground (docs/light.md)
  uint32_t host_budget_mb = 1024;          ///< most memory for blocks of rasters and tiles, MiB (docs/streaming.md)
  uint32_t gpu_budget_mb = 512;            ///< most GPU memory for tiles, MiB
  uint32_t disk_cache_mb = 1024;           ///< most space for warped blocks on disk, MiB; 0: none are kept there
  double source_timeout_s = 20.0;          ///< a source that does not answer within this time has failed, s, > 0
  std::string water_mask;                  ///< raster, white: water; empty: water is where elevation is at most 0
  double water_wind_mps = 6.0;  ///< 10 m wind that roughens water, m/s; 6: a moderate breeze, the ocean's mean
  bool operator==(const TerrainParams&) const = default;
};

struct ImageryParams {
  std::vector<ImagerySource> files;  ///< rasters over the default Earth, later over earlier
  double bare_albedo = 0.2;          ///< of ground that no imagery covers, 0..1
  bool operator==(const ImageryParams&) const = default;
};

struct RenderParams {
  uint32_t width = 640;            ///< px, 1..16384
  uint32_t height = 360;           ///< px
  std::string quality = "medium";  ///< low, medium, high, ultra; reference: a path tracer (docs/reference.md)
  uint32_t upscale = 1;            ///< pixels per marched pixel of clouds: 16, 4, 2, 1 (docs/performance.md)
  uint32_t frames = 1;             ///< frames accumulated, >= 1; of `reference` paths a pixel
  double noise = 0.0;          ///< reference: stop when 95 % of pixels have this relative standard error; 0: by frames
  double furnace_cd_m2 = 0.0;  ///< reference: > 0: this luminance from all sides, instead of air, sun and ground
  uint32_t seed = 0;
  std::optional<double> exposure_ev100;  ///< without: from the picture's own luminances
  double min_ev100 = -8.0;               ///< automatic exposure stays within min_ev100..max_ev100
  double max_ev100 = 17.0;
  double exposure_compensation_ev = 0.0;  ///< added to the automatic exposure's brightness, stops
  double exposure_adaptation_s = 1.0;     ///< time constant of automatic exposure in sequences, s; stills do not adapt
  double white_balance_k = 5500.0;  ///< daylight that PNG pictures show as white, K, 4000..25000; 6504 changes nothing
  std::string tone_curve = "agx";   ///< aces, agx, reinhard, linear
  bool operator==(const RenderParams&) const = default;
};

/// What the night sky holds besides the air.
struct NightSkyParams {
  bool stars = true;              ///< of the Bright Star Catalogue
  bool moon = true;               ///< its disc and its light
  double airglow_cd_m2 = 1.0e-4;  ///< luminance of the airglow layer seen vertically from below, cd/m2, >= 0
  bool operator==(const NightSkyParams&) const = default;
};

/// A picture as plain data: everything has a default, is saved and read back (scene_json.h).
struct Scene {
  std::string time = "2026-06-20T23:30:00Z";  ///< UTC, ISO 8601; a fixed date, never now
  CameraParams camera;
  AtmosphereParams atmosphere;
  NightSkyParams night_sky;
  CloudParams clouds = cloud_sky("earth").value();
  ShaftParams shafts;
  HazeParams haze;
  TerrainParams terrain;
  ImageryParams imagery;
  RenderParams render;
  bool operator==(const Scene&) const = default;
};

}  // namespace nepho
