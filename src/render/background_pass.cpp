#include "render/background_pass.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "gpu/commands.h"
#include "render/background.comp.h"
#include "render/composite.comp.h"
#include "render/discs.comp.h"
#include "render/render_shared.h"
#include "render/shaft_shared.h"
#include "render/sky.comp.h"

namespace nepho {

static_assert(sizeof(shared::BackgroundPush) == 24);

BackgroundPass::BackgroundPass(gpu::Device& device, uint32_t spectral_groups)
    : device_(device), spectral_groups_(spectral_groups) {}

const gpu::ComputePipeline& BackgroundPass::pipeline(Kind kind, bool night, uint32_t haze_layers, bool volume) const {
  gpu::ComputePipeline& wanted =
      pipelines_[{static_cast<uint32_t>(kind), night ? 1u : 0u, haze_layers, volume ? 1u : 0u}];
  if (!wanted) {
    const std::span<const uint32_t> spirv[] = {background_comp, sky_comp, discs_comp};
    const char* const names[] = {"background.surface", "background.sky", "background.discs"};
    wanted = gpu::ComputePipeline(device_,
                                  {.name = names[kind],
                                   .spirv = spirv[kind],
                                   .constants = {spectral_groups_, night ? 1u : 0u, haze_layers, volume ? 1u : 0u}});
  }
  return wanted;
}

ImageRef BackgroundPass::add(FrameGraph& graph, const FrameInfo& frame, const AtmosphereParams& params,
                             const Inputs& in) const {
  const ImageRef out = graph.create("background", {.extent = frame.extent, .format = Format::rgba32f});
  const Extent3D nodes = in.cloud_light ? graph.desc(in.cloud_light).extent : Extent3D{0, 0};
  const shared::BackgroundPush push{in.wind_mps,
                                    in.terrain.emission ? kNightLight_cd_m2 : 0.0f,
                                    in.sun_visibility ? 1u : 0u,
                                    static_cast<float>(params.ground_albedo),
                                    {nodes.width, nodes.height}};
  for (const bool sky_tiles : {false, true}) {
    const BufferRef tiles = sky_tiles ? in.terrain.sky_tiles : in.terrain.surface_tiles;
    auto pass = graph.pass(sky_tiles ? "background.sky" : "background.surface");
    pass.uniform("frame", frame.buffer).read("pixel_tiles", tiles).indirect(tiles).write("background", out);
    AtmosphereTables::bind(pass, in.atmosphere);
    NightSky::bind(pass, in.night_sky);
    if (sky_tiles && in.has_sky_view) {
      pass.record([this, night = in.night](gpu::Commands& cmd) { cmd.bind(pipeline(sky, night)).dispatch_indirect(); });
      continue;
    }
    // High up and from space the sky is integrated as surfaces are, by the same shader.
    pass.uniform("shafts", in.shafts ? in.shafts : graph.constants("shafts", shared::ShaftData{}))
        .sample("depth_m", in.terrain.depth_m, Sampler::nearest_clamp)
        .sample("albedo", in.terrain.albedo, Sampler::nearest_clamp)
        .sample("normal", in.terrain.normal, Sampler::nearest_clamp)
        .sample("emission", in.terrain.emission ? in.terrain.emission : in.terrain.albedo, Sampler::nearest_clamp)
        .sample("cloud_light", in.cloud_light ? in.cloud_light : in.terrain.depth_m, Sampler::nearest_clamp)
        .sample("sun_visible_share", in.sun_visibility ? in.sun_visibility : in.terrain.depth_m,
                Sampler::nearest_clamp);
    AirVolume::bind(graph, pass, in.air_volume, in.atmosphere);
    const gpu::ComputePipeline& shader = pipeline(surface, in.night, in.haze_layers, static_cast<bool>(in.air_volume));
    pass.record([&shader, push](gpu::Commands& cmd) { cmd.bind(shader).push(push).dispatch_indirect(); });
  }
  add_discs(graph, frame, in, out);
  return out;
}

void BackgroundPass::add_discs(FrameGraph& graph, const FrameInfo& frame, const Inputs& in, ImageRef background) const {
  const shared::FrameConstants& c = frame.constants;
  const auto sun = pixels_of_disc(c, c.sun_dir, c.sun_angular_radius_rad);
  const auto moon = pixels_of_disc(c, c.moon_dir, c.moon_angular_radius_rad);
  std::vector<shared::DiscsPush> areas;
  const bool overlap = sun && moon && all(lessThan(sun->first, moon->last)) && all(lessThan(moon->first, sun->last));
  if (overlap) {  // once, so that no pixel gets its discs twice
    areas.push_back({min(sun->first, moon->first), max(sun->last, moon->last)});
  } else {
    if (sun) areas.push_back(*sun);
    if (moon) areas.push_back(*moon);
  }
  if (areas.empty()) return;
  auto pass = graph.pass("background.discs");
  pass.uniform("frame", frame.buffer)
      .sample("depth_m", in.terrain.depth_m, Sampler::nearest_clamp)
      .read_write("background", background);
  AtmosphereTables::bind(pass, in.atmosphere);
  NightSky::bind(pass, in.night_sky);
  pass.record([this, areas, night = in.night](gpu::Commands& cmd) {
    for (const shared::DiscsPush& area : areas) {
      const glm::ivec2 size = area.last - area.first;
      cmd.bind(pipeline(discs, night))
          .push(area)
          .dispatch_threads(static_cast<uint32_t>(size.x), static_cast<uint32_t>(size.y));
    }
  });
}

std::optional<shared::DiscsPush> pixels_of_disc(const shared::FrameConstants& frame, const glm::vec3& dir,
                                                float angular_radius_rad) {
  const float radius = angular_radius_rad * 1.05f + 3.0f * frame.pixel_angle_rad;  // edges are smoothed over a pixel
  const glm::ivec2 size(frame.size);
  if (radius > 1.0f) return shared::DiscsPush{glm::ivec2(0), size};  // a pixel or two in a wide picture
  glm::vec2 low(1e9f), high(-1e9f), centre(0.0f);
  if (!shared::pixel_from_direction(frame, dir, centre)) {
    // Behind the camera; the disc may still reach into a very wide picture.
    if (dot(dir, normalize(frame.forward)) < -std::sin(radius)) return std::nullopt;
    return shared::DiscsPush{glm::ivec2(0), size};
  }
  const glm::vec3 side = normalize(cross(dir, std::abs(dir.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0)));
  const glm::vec3 above = cross(side, dir);
  // A circle becomes an ellipse, which its tangents at 16 points enclose: 1 / cos(pi / 16) outside.
  const float rim = std::tan(radius) * 1.02f;
  for (int i = 0; i < 16; ++i) {
    const float a = static_cast<float>(i) * (shared::kPi / 8.0f);
    glm::vec2 p(0.0f);
    if (!shared::pixel_from_direction(frame, normalize(dir + rim * (std::cos(a) * side + std::sin(a) * above)), p))
      return shared::DiscsPush{glm::ivec2(0), size};
    low = min(low, p);
    high = max(high, p);
  }
  const glm::ivec2 first = clamp(glm::ivec2(floor(max(low, glm::vec2(-1.0f)))), glm::ivec2(0), size);
  const glm::ivec2 last = clamp(glm::ivec2(ceil(min(high, glm::vec2(size) + 1.0f))) + 1, glm::ivec2(0), size);
  if (any(greaterThanEqual(first, last)) || any(lessThan(high, glm::vec2(0.0f))) ||
      any(greaterThan(low, glm::vec2(size))))
    return std::nullopt;
  return shared::DiscsPush{first, last};
}

CompositePass::CompositePass(gpu::Device& device) : pipeline_(device, {.name = "composite", .spirv = composite_comp}) {}

ImageRef CompositePass::add(FrameGraph& graph, const FrameInfo& frame, ImageRef background,
                            ImageRef cloud_radiance) const {
  const ImageRef out = graph.create("radiance", {.extent = frame.extent, .format = Format::rgba32f});
  graph.pass("composite")
      .sample("background", background, Sampler::nearest_clamp)
      .sample("cloud_radiance", cloud_radiance, Sampler::nearest_clamp)
      .write("radiance", out)
      .record([this, extent = frame.extent](gpu::Commands& cmd) {
        cmd.bind(pipeline_).dispatch_threads(extent.width, extent.height);
      });
  return out;
}

}  // namespace nepho
