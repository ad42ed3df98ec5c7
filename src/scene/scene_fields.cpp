#include "scene/scene_fields.h"

#include <fmt/format.h>

#include <cmath>

#include "scene/atmosphere_fields.h"
#include "scene/cloud_fields.h"
#include "scene/field_ranges.h"
#include "scene/shaft_fields.h"
#include "scene/source_fields.h"

namespace nepho {

namespace {

// Below the deepest trench; beyond the Moon's orbit no cloud is a pixel wide.
const Range kHeights = closed(-12000.0, 1e9);

void describe(FieldVisitor& v, LookAt& p) {
  v.leaf({.name = "lat_deg",
          .doc = "latitude, north positive",
          .unit = "deg",
          .range = closed(-90, 90),
          .term = "geodetic latitude"},
         &p.lat_deg);
  v.leaf({.name = "lon_deg", .doc = "longitude, east positive", .unit = "deg", .range = closed(-180, 360)}, &p.lon_deg);
  v.leaf({.name = "height_m",
          .doc = "height above the WGS84 ellipsoid; null: the ground there",
          .unit = "m",
          .range = kHeights,
          .term = "ellipsoidal height"},
         &p.height_m);
}

void describe(FieldVisitor& v, CameraParams& p) {
  v.leaf({.name = "lat_deg",
          .doc = "latitude, north positive",
          .unit = "deg",
          .range = closed(-90, 90),
          .term = "geodetic latitude"},
         &p.lat_deg);
  v.leaf({.name = "lon_deg", .doc = "longitude, east positive", .unit = "deg", .range = closed(-180, 360)}, &p.lon_deg);
  v.leaf({.name = "height_m",
          .doc = "height above the WGS84 ellipsoid, instead of agl_m",
          .unit = "m",
          .range = kHeights,
          .term = "ellipsoidal height"},
         &p.height_m);
  v.leaf({.name = "agl_m",
          .doc = "height above the ground, instead of height_m; with neither the camera stands 2 m above the ground",
          .unit = "m",
          .range = closed(0, 1e9),
          .term = "height above ground level"},
         &p.agl_m);
  v.leaf({.name = "heading_deg",
          .doc = "direction of view, clockwise from north",
          .unit = "deg",
          .range = closed(-360, 360),
          .term = "azimuth"},
         &p.heading_deg);
  v.leaf({.name = "pitch_deg",
          .doc = "direction of view: 0 the horizontal, -90 straight down",
          .unit = "deg",
          .range = closed(-90, 90),
          .term = "elevation angle"},
         &p.pitch_deg);
  v.leaf({.name = "roll_deg",
          .doc = "turn of the camera about its axis, clockwise as seen from behind it",
          .unit = "deg",
          .range = closed(-360, 360)},
         &p.roll_deg);
  v.items({.name = "look_at", .doc = "a point to look at, instead of heading and pitch; null: none"},
          {.list = false,
           .max = 1,
           .size = [&p] { return p.look_at ? size_t{1} : size_t{0}; },
           .resize =
               [&p](size_t n) {
                 p.look_at.reset();
                 if (n > 0) p.look_at.emplace();
               },
           .visit = [&p](FieldVisitor& visitor, size_t) { describe(visitor, *p.look_at); },
           .visit_default =
               [](FieldVisitor& visitor) {
                 LookAt defaults;
                 describe(visitor, defaults);
               }});
  v.leaf({.name = "fov_deg",
          .doc = "vertical angle of view",
          .unit = "deg",
          .range = open(0, 180),
          .term = "vertical field of view"},
         &p.fov_deg);
  v.leaf({.name = "allow_underground",
          .doc = "keep a camera that is under the ground where it is; false: it is lifted to 2 m above the ground"},
         &p.allow_underground);
}

void describe(FieldVisitor& v, TerrainParams& p) {
  describe_stack(v,
                 {.name = "elevation",
                  .doc = "elevation rasters over the default Earth, later ones over earlier ones: paths, or objects "
                         "with a path and settings",
                  .standard = "none"},
                 p.elevation);
  v.leaf({.name = "default_earth",
          .doc = "elevation and imagery of the whole Earth from Debian packages, where they are installed"},
         &p.default_earth);
  v.leaf({.name = "screen_error_px",
          .doc = "largest error of the ground's shape on screen; more is faster and coarser",
          .unit = "px",
          .range = closed(0.05, 64),
          .term = "screen-space error"},
         &p.screen_error_px);
  v.leaf({.name = "shadows", .doc = "mountains shade other ground", .term = "cast shadows"}, &p.shadows);
  v.leaf({.name = "host_budget_mb",
          .doc = "most memory for the rasters' blocks and the tiles made of them",
          .unit = "MiB",
          .range = closed(1, 1048576)},
         &p.host_budget_mb);
  v.leaf({.name = "gpu_budget_mb",
          .doc = "most GPU memory for tiles of the ground",
          .unit = "MiB",
          .range = closed(1, 1048576)},
         &p.gpu_budget_mb);
  v.leaf({.name = "disk_cache_mb",
          .doc = "most space on disk for blocks of rasters that were warped or fetched; 0: none are kept there",
          .unit = "MiB",
          .range = closed(0, 16777216)},
         &p.disk_cache_mb);
  v.leaf({.name = "source_timeout_s",
          .doc = "a source that does not answer within this time has failed",
          .unit = "s",
          .range = closed(0.1, 3600)},
         &p.source_timeout_s);
  v.leaf(
      {.name = "water_mask",
       .doc = "raster of water, white, and land, black (threshold 128); empty: water is where elevation is at most 0",
       .text = TextKind::optional_file},
      &p.water_mask);
  v.leaf({.name = "water_wind_mps",
          .doc = "wind at 10 m that roughens water; more widens the sun's glint",
          .unit = "m/s",
          .range = closed(0, 60),
          .term = "Cox and Munk 1954"},
         &p.water_wind_mps);
}

void describe(FieldVisitor& v, ImageryParams& p) {
  describe_stack(v,
                 {.name = "files",
                  .doc = "imagery rasters over the default Earth, later ones over earlier ones: paths, or objects with "
                         "a path and settings",
                  .standard = "none"},
                 p.files);
  v.leaf({.name = "bare_albedo", .doc = "albedo of ground that no imagery covers", .range = share(), .term = "albedo"},
         &p.bare_albedo);
}

void describe(FieldVisitor& v, RenderParams& p) {
  v.leaf({.name = "width", .doc = "width of the picture", .unit = "px", .range = closed(1, 16384)}, &p.width);
  v.leaf({.name = "height", .doc = "height of the picture", .unit = "px", .range = closed(1, 16384)}, &p.height);
  v.leaf({.name = "quality",
          .doc = "preset of steps and sizes; higher is slower and finer; reference traces paths",
          .choices = {"low", "medium", "high", "ultra", "reference"}},
         &p.quality);
  v.leaf({.name = "upscale",
          .doc = "pixels per pixel whose clouds are marched in a frame of a sequence: 16, 4, 2 or 1; the others follow "
                 "from frames before",
          .range = closed(1, 16),
          .term = "temporal upscaling"},
         &p.upscale);
  v.leaf({.name = "frames",
          .doc = "frames that are accumulated into the picture; of quality reference paths a pixel",
          .range = closed(1, 16777216)},
         &p.frames);
  v.leaf(
      {.name = "noise",
       .doc = "quality reference goes on until 95 % of the pixels have this relative standard error, but for no more "
              "than `frames` paths a pixel where frames is above 1; 0: as many paths as frames",
       .range = closed(0, 1),
       .term = "relative standard error"},
      &p.noise);
  v.leaf({.name = "furnace_cd_m2",
          .doc = "quality reference: above 0 an even luminance from all sides, instead of air, sun and ground",
          .unit = "cd/m2",
          .range = closed(0, 1e9),
          .term = "white furnace"},
         &p.furnace_cd_m2);
  v.leaf({.name = "seed", .doc = "start of every pseudo-random sequence", .range = closed(0, 4294967295.0)}, &p.seed);
  v.leaf({.name = "exposure_ev100",
          .doc = "exposure of PNG pictures; null: from the picture's own luminances",
          .unit = "EV",
          .range = closed(-30, 40),
          .term = "exposure value at ISO 100 (ISO 2720)"},
         &p.exposure_ev100);
  v.leaf({.name = "min_ev100",
          .doc = "the least exposure value that automatic exposure takes: night stays darker than day",
          .unit = "EV",
          .range = closed(-30, 40)},
         &p.min_ev100);
  v.leaf({.name = "max_ev100",
          .doc = "the largest exposure value that automatic exposure takes, not below min_ev100",
          .unit = "EV",
          .range = closed(-30, 40)},
         &p.max_ev100);
  v.leaf({.name = "exposure_compensation_ev",
          .doc = "makes automatic exposures brighter by so many stops",
          .unit = "EV",
          .range = closed(-20, 20),
          .term = "exposure compensation"},
         &p.exposure_compensation_ev);
  v.leaf({.name = "exposure_adaptation_s",
          .doc = "time over which automatic exposure follows the light in sequences; stills do not adapt",
          .unit = "s",
          .range = closed(0, 3600),
          .term = "time constant of adaptation"},
         &p.exposure_adaptation_s);
  v.leaf({.name = "white_balance_k",
          .doc = "daylight that PNG pictures show as white; 6504 changes nothing",
          .unit = "K",
          .range = closed(4000, 25000),
          .term = "correlated colour temperature (CIE daylight)"},
         &p.white_balance_k);
  v.leaf({.name = "tone_curve",
          .doc = "how radiance becomes the colours of PNG pictures",
          .term = "tone mapping operator",
          .choices = {"aces", "agx", "reinhard", "linear"}},
         &p.tone_curve);
}

}  // namespace

bool Range::contains(double value) const {
  if (!std::isfinite(value)) return false;
  return (min_open ? value > min : value >= min) && (max_open ? value < max : value <= max);
}

std::string Range::text(const std::string& unit) const {
  const std::string suffix = unit.empty() ? "" : " " + unit;
  const bool has_min = std::isfinite(min), has_max = std::isfinite(max);
  if (!has_min && !has_max) return "any finite number";
  if (has_min && has_max && !min_open && !max_open) return fmt::format("{}..{}{}", min, max, suffix);
  const std::string low = has_min ? fmt::format("{} {}", min_open ? ">" : ">=", min) : "";
  const std::string high = has_max ? fmt::format("{} {}", max_open ? "<" : "<=", max) : "";
  return low + (has_min && has_max ? " and " : "") + high + suffix;
}

namespace {
/// Appends a segment to a path for as long as it lives.
class PathScope {
 public:
  PathScope(std::string& path, const std::string& segment) : path_(path), length_(path.size()) {
    if (!path_.empty() && segment[0] != '[') path_ += '.';
    path_ += segment;
  }
  ~PathScope() { path_.resize(length_); }
  PathScope(const PathScope&) = delete;
  PathScope& operator=(const PathScope&) = delete;

 private:
  std::string& path_;
  size_t length_;
};
}  // namespace

void FieldVisitor::leaf(const Field& field, Leaf value) {
  const PathScope scope(path_, field.name);
  on_leaf(field, value);
}
void FieldVisitor::group(const Field& field, const std::function<void()>& members) {
  const PathScope scope(path_, field.name);
  on_group(field, members);
}
void FieldVisitor::items(const Field& field, const Items& items) {
  const PathScope scope(path_, field.name);
  on_items(field, items);
}
void FieldVisitor::preset(const Field& field, const std::function<bool(const std::string&)>& apply) {
  const PathScope scope(path_, field.name);
  on_preset(field, apply);
}
void FieldVisitor::at_index(size_t index, const std::function<void()>& visit) {
  const PathScope scope(path_, fmt::format("[{}]", index));
  visit();
}

void visit_fields(FieldVisitor& v, Scene& scene) {
  v.leaf({.name = "time",
          .doc = "UTC, ISO 8601, from 1900 to 2100; a zone such as +09:00 is converted, none means UTC",
          .text = TextKind::utc},
         &scene.time);
  v.group({.name = "camera", .doc = "where the picture is taken from"}, [&] { describe(v, scene.camera); });
  v.group({.name = "atmosphere", .doc = "clear air"}, [&] { describe(v, scene.atmosphere); });
  v.group({.name = "night_sky", .doc = "what the night sky holds besides the air"},
          [&] { describe(v, scene.night_sky); });
  v.group({.name = "clouds", .doc = "the sky's clouds"}, [&] { describe(v, scene.clouds); });
  v.group({.name = "shafts", .doc = "light shafts between clouds and ground"}, [&] { describe(v, scene.shafts); });
  v.group({.name = "haze", .doc = "haze and fog in layers"}, [&] { describe(v, scene.haze); });
  v.group({.name = "terrain", .doc = "the shape of the ground"}, [&] { describe(v, scene.terrain); });
  v.group({.name = "imagery", .doc = "the colours of the ground"}, [&] { describe(v, scene.imagery); });
  v.group({.name = "render", .doc = "the picture"}, [&] { describe(v, scene.render); });
}

}  // namespace nepho
