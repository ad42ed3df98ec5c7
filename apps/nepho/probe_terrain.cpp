#include "gpu/device.h"
#include "probe_tables.h"
#include "render/camera_pose.h"
#include "render/frame_setup.h"
#include "terrain/ground_picker.h"
#include "terrain/surface_query.h"

namespace nepho {

namespace {

using Type = ProbeInput::Type;

TerrainSources sources_of(const ProbeOptions& options) {
  return options.open_terrain ? options.open_terrain(options.scene) : TerrainSources{};
}

/// The drawn ground at places.
std::vector<ProbeColumn> surface(const ProbeTable& in, const ProbeOptions& options) {
  const auto lat = in.numbers("lat_deg"), lon = in.numbers("lon_deg");
  std::vector<ProbeColumn> out{{"height_m", {}}, {"height_msl_m", {}}, {"slope_deg", {}}, {"source", {}}};
  if (in.rows() == 0) return out;
  TerrainSources sources = sources_of(options);
  const HeightSampler ground(std::move(sources.elevation), sources.has_default, std::move(sources.geoid));
  for (size_t row = 0; row < in.rows(); ++row) {
    const SurfacePoint at = surface_at(ground, rad_from_deg(lat[row]), rad_from_deg(lon[row]));
    out[0].values.push_back(at.height_m);
    out[1].values.push_back(at.height_msl_m);
    out[2].values.push_back(deg_from_rad(at.slope_rad));
    out[3].texts.push_back(at.source);
  }
  return out;
}

/// The ground that pixels of the scene's picture show.
std::vector<ProbeColumn> picks(const ProbeTable& in, const ProbeOptions& options) {
  const auto x = in.numbers("x_px"), y = in.numbers("y_px");
  const RenderParams& render = options.scene.render;
  for (size_t row = 0; row < in.rows(); ++row) {
    if (x[row] < 0.0 || x[row] > render.width)
      throw in.bad_cell(row, "x_px", fmt::format("{} is outside the picture, 0..{}", x[row], render.width));
    if (y[row] < 0.0 || y[row] > render.height)
      throw in.bad_cell(row, "y_px", fmt::format("{} is outside the picture, 0..{}", y[row], render.height));
  }
  std::vector<ProbeColumn> out{{"lat_deg", {}}, {"lon_deg", {}}, {"height_m", {}}, {"distance_m", {}}, {"hit", {}}};
  if (in.rows() == 0) return out;
  gpu::Device device({.device = options.device});
  Terrain terrain(device, sources_of(options), options.scene.terrain);
  const CameraPose pose = resolve_camera(options.scene.camera, terrain.heights());
  warn_if_lifted(pose);
  FrameInfo frame;
  frame.extent = {render.width, render.height};
  frame.camera_ecef_m = pose.ecef_m;
  frame.constants = make_frame_constants(pose, frame.extent, FrameLight{}, 0.0, 0, render.seed, frame_jitter(0));
  terrain.prepare(frame);
  const GroundPicker picker(terrain, frame);
  constexpr double kBlank = std::numeric_limits<double>::quiet_NaN();
  for (size_t row = 0; row < in.rows(); ++row) {
    const std::optional<GroundHit> hit = picker.at(x[row], y[row]);
    const Geodetic at = hit ? geodetic_from_ecef(hit->point_ecef_m) : Geodetic{};
    out[0].values.push_back(hit ? at.lat_deg() : kBlank);
    out[1].values.push_back(hit ? at.lon_deg() : kBlank);
    out[2].values.push_back(hit ? at.height_m : kBlank);
    out[3].values.push_back(hit ? hit->distance_m : kBlank);
    out[4].values.push_back(hit ? 1.0 : 0.0);
  }
  return out;
}

}  // namespace

std::vector<ProbeKind> terrain_probe_kinds() {
  return {{"terrain", {{"lat_deg", Type::latitude_deg}, {"lon_deg"}}, surface}, {"pick", {{"x_px"}, {"y_px"}}, picks}};
}

}  // namespace nepho
