#include "render/output_layers.h"

#include <algorithm>
#include <cmath>

#include "common/shared.h"

namespace nepho {

namespace {

/// Adds a channel filled by f(pixel index).
template <typename F>
void add_channel(ImageBuffer& out, const std::string& name, const F& f) {
  const size_t count = size_t{out.width} * out.height;
  ImageChannel channel{name, std::vector<float>(count)};
  for (size_t i = 0; i < count; ++i) channel.values[i] = f(i);
  out.channels.push_back(std::move(channel));
}

void add_rgb(ImageBuffer& out, const std::string& prefix, const std::vector<float>& rgba) {
  constexpr const char* names[] = {"R", "G", "B"};
  for (size_t c = 0; c < 3; ++c) add_channel(out, prefix + names[c], [&](size_t i) { return rgba[4 * i + c]; });
}

void add_positions(ImageBuffer& out, const FrameReadback& frame, const CameraPose& pose) {
  const size_t count = size_t{out.width} * out.height;
  const double tan_y = std::tan(0.5 * pose.fov_rad);
  const double tan_x = tan_y * out.width / out.height;
  constexpr const char* names[] = {"dx_m", "dy_m", "dz_m", "lat_deg", "lon_deg", "height_m"};
  std::vector<ImageChannel> channels;
  for (const char* name : names) channels.push_back({std::string("position.") + name, std::vector<float>(count, 0.0f)});
  for (size_t i = 0; i < count; ++i) {
    const double depth = static_cast<double>(frame.depth_m[i]);
    if (depth >= 0.5 * static_cast<double>(shared::kFarDepth_m)) continue;
    const double x = 2.0 * (static_cast<double>(i % out.width) + 0.5) / out.width - 1.0;
    const double y = 1.0 - 2.0 * (static_cast<double>(i / out.width) + 0.5) / out.height;
    const vec3 d =
        vec3(glm::normalize(pose.axes.forward + x * tan_x * pose.axes.right + y * tan_y * pose.axes.up) * depth);
    const Geodetic at = geodetic_from_ecef(pose.ecef_m + dvec3(d));
    const float values[] = {d.x,
                            d.y,
                            d.z,
                            static_cast<float>(at.lat_deg()),
                            static_cast<float>(at.lon_deg()),
                            static_cast<float>(at.height_m)};
    for (size_t c = 0; c < channels.size(); ++c) channels[c].values[i] = values[c];
  }
  for (ImageChannel& c : channels) out.channels.push_back(std::move(c));
}

}  // namespace

const std::vector<std::string>& known_layers() {
  static const std::vector<std::string> names = {"depth",
                                                 "depth.Z",
                                                 "position",
                                                 "position.lat_deg",
                                                 "position.lon_deg",
                                                 "position.height_m",
                                                 "position.dx_m",
                                                 "position.dy_m",
                                                 "position.dz_m",
                                                 "surface",
                                                 "surface.R",
                                                 "surface.G",
                                                 "surface.B",
                                                 "surface.mask",
                                                 "surface.shadow",
                                                 "albedo",
                                                 "albedo.R",
                                                 "albedo.G",
                                                 "albedo.B",
                                                 "cloud",
                                                 "cloud.R",
                                                 "cloud.G",
                                                 "cloud.B",
                                                 "cloud.transmittance",
                                                 "cloud.optical_depth",
                                                 "cloud.depth_m",
                                                 "cloud.layer",
                                                 "sun",
                                                 "sun.transmittance",
                                                 "variance",
                                                 "variance.R",
                                                 "variance.G",
                                                 "variance.B",
                                                 "samples"};
  return names;
}

ImageBuffer make_output_layers(const FrameReadback& frame, const CameraPose& pose,
                               const std::set<std::string>& wanted) {
  ImageBuffer out;
  out.width = frame.extent.width;
  out.height = frame.extent.height;
  // A group ("position") stands for all of its channels.
  const auto want_channel = [&](const std::string& name) {
    return wanted.empty() || wanted.contains(name) || wanted.contains(name.substr(0, name.find('.')));
  };
  const auto want_some = [&](const std::string& group) {
    return wanted.empty() || std::any_of(wanted.begin(), wanted.end(), [&](const std::string& w) {
             return w == group || w.starts_with(group + ".");
           });
  };
  add_rgb(out, "", frame.radiance);
  if (want_some("depth")) add_channel(out, "depth.Z", [&](size_t i) { return frame.depth_m[i]; });
  if (want_some("position")) add_positions(out, frame, pose);
  if (want_some("surface")) {
    add_rgb(out, "surface.", frame.background);
    add_channel(out, "surface.mask", [&](size_t i) { return std::round(frame.albedo[4 * i + 3]); });
  }
  if (!frame.shadow.empty()) {
    if (want_some("surface")) add_channel(out, "surface.shadow", [&](size_t i) { return frame.shadow[2 * i]; });
    if (want_some("sun")) add_channel(out, "sun.transmittance", [&](size_t i) { return frame.shadow[2 * i + 1]; });
  }
  if (want_some("albedo")) add_rgb(out, "albedo.", frame.albedo);
  if (want_some("cloud")) {
    add_rgb(out, "cloud.", frame.cloud);
    add_channel(out, "cloud.transmittance", [&](size_t i) { return frame.cloud[4 * i + 3]; });
    add_channel(out, "cloud.depth_m", [&](size_t i) { return frame.cloud_info[4 * i]; });
    add_channel(out, "cloud.optical_depth", [&](size_t i) { return frame.cloud_info[4 * i + 1]; });
    add_channel(out, "cloud.layer", [&](size_t i) { return frame.cloud_info[4 * i + 2]; });
  }
  if (!frame.variance.empty()) {
    if (want_some("variance")) add_rgb(out, "variance.", frame.variance);
    if (want_some("samples")) add_channel(out, "samples", [&](size_t i) { return frame.variance[4 * i + 3]; });
  }
  std::erase_if(out.channels, [&](const ImageChannel& c) { return c.name.size() > 1 && !want_channel(c.name); });
  return out;
}

}  // namespace nepho
