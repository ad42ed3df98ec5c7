#include "atmosphere/atmosphere_tables.h"

#include <chrono>
#include <cstring>

#include "atmosphere/atmosphere_build.h"
#include "atmosphere/atmosphere_cache.h"
#include "atmosphere/sky_view.comp.h"
#include "atmosphere/sky_view.h"
#include "base/error.h"
#include "base/files.h"
#include "base/log.h"
#include "gpu/commands.h"

namespace nepho {

namespace {

constexpr uint32_t u32(int n) { return static_cast<uint32_t>(n); }

template <typename T>
uint64_t hash_value(const T& value, uint64_t seed) {
  return hash_bytes(std::as_bytes(std::span(&value, 1)), seed);
}

/// Everything that the tables depend on but the device's rounding: parameters and shaders (with their sizes).
uint64_t cache_key(const AtmosphereParams& p, const AtmosphereConstants& constants) {
  uint64_t key = atmosphere_build_hash();
  key = hash_value(constants.data, key);
  key = hash_value(constants.spectral_groups, key);
  key = hash_value(p.scattering_orders, key);
  return key;
}

uint64_t hash_of(const gpu::DeviceInfo& device) {
  const std::string who = device.name + device.driver;
  return hash_bytes(std::as_bytes(std::span(who)));
}

}  // namespace

AtmosphereTables::AtmosphereTables(gpu::Device& device, const AtmosphereParams& params, Start start)
    : device_(device), params_(params), constants_(make_atmosphere_constants(params)) {
  const auto began = std::chrono::steady_clock::now();
  const uint32_t x = u32(shared::kAirNu * shared::kAirMuS);
  transmittance_ = device.create_image(
      {"atmosphere.transmittance_tex", {u32(shared::kColumnMu), u32(shared::kColumnR)}, Format::rgba32f});
  irradiance_ = device.create_image({"atmosphere.irradiance_tex",
                                     {u32(shared::kAirMuS), u32(shared::kIrradianceParts * shared::kAirR)},
                                     Format::rgba32f});
  source_ =
      device.create_image({"atmosphere.source_tex", {x, u32(shared::kSourceMu), u32(shared::kAirR)}, Format::rgba32f});
  mirror_ = device.create_image({"atmosphere.mirror_tex", {x, u32(shared::kMirrorMu), 3}, Format::rgba32f});
  sky_view_ = gpu::ComputePipeline(device, {"atmosphere.sky_view", sky_view_comp, {spectral_groups()}});

  key_ = cache_key(params, constants_);
  came_from_cache_ = load();
  if (!came_from_cache_) {
    log_info("computing the atmosphere's tables ({} scattering orders)", params.scattering_orders);
    build_ = std::make_unique<AtmosphereBuild>(device, constants_, params.scattering_orders,
                                               AtmosphereTableTargets{transmittance_, irradiance_, source_, mirror_});
  }
  build_ms_ = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
  if (start == Start::at_once) advance(1e300);
}

AtmosphereTables::~AtmosphereTables() = default;

double AtmosphereTables::progress() const {
  return build_ ? static_cast<double>(build_->steps_done()) / build_->steps() : 1.0;
}

bool AtmosphereTables::advance(double budget_ms) {
  if (!build_) return true;
  const auto began = std::chrono::steady_clock::now();
  const auto spent_ms = [&] {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
  };
  bool more = true;
  do more = build_->step() && build_->steps_done() < build_->steps();
  while (more && spent_ms() < budget_ms);
  if (!more) {
    step_ms_ = build_->times();
    build_.reset();
    save();
  }
  build_ms_ += spent_ms();
  return !build_;
}

std::string AtmosphereTables::cache_name() const { return fmt::format("atmosphere-{:016x}.bin", key_); }

bool AtmosphereTables::load() {
  std::vector<size_t> sizes;
  for (const gpu::Image* image : images()) {
    const ImageDesc& d = image->desc();
    sizes.push_back(size_t{d.extent.width} * d.extent.height * d.extent.depth * bytes_per_texel(d.format));
  }
  const auto blocks = load_cached_blocks(cache_name(), key_, hash_of(device_.info()), sizes);
  if (!blocks) return false;
  std::vector<gpu::ImageUpload> uploads;
  for (size_t i = 0; i < blocks->size(); ++i) uploads.push_back({images()[i], (*blocks)[i], 0, 0});
  device_.upload(uploads);
  return true;
}

void AtmosphereTables::save() const {
  std::vector<std::vector<std::byte>> blocks;
  for (const gpu::Image* image : images()) blocks.push_back(device_.download(*image));
  save_cached_blocks(cache_name(), key_, hash_of(device_.info()), blocks);
}

AtmosphereTables::Refs AtmosphereTables::add(FrameGraph& graph, std::span<const shared::SkyView> views) const {
  NEPHO_ASSERT(ready());
  Refs refs{.transmittance = graph.import(transmittance_),
            .irradiance = graph.import(irradiance_),
            .source = graph.import(source_),
            .mirror = graph.import(mirror_),
            .sky_view = {},
            .params = graph.constants("atmosphere", constants_.data),
            .sky_views = {}};
  if (views.empty()) {
    // Bound, but never read: every ray of such a camera is integrated.
    refs.sky_view = refs.transmittance;
    refs.sky_views = graph.constants("sky_views", std::array<shared::SkyView, 2>{});
    return refs;
  }
  const auto count = static_cast<uint32_t>(views.size());
  const glm::uvec2 extent = sky_view_extent(static_cast<int>(count));
  std::vector<shared::SkyView> at_least_two(views.begin(), views.end());  // shaders declare two
  at_least_two.resize(std::max<size_t>(views.size(), 2));
  refs.sky_views = graph.constants("sky_views", at_least_two);
  refs.sky_view = graph.create("atmosphere.sky_view", {.extent = {extent.x, extent.y}, .format = Format::rgba32f});
  graph.pass("atmosphere.sky_view")
      .uniform("atmosphere", refs.params)
      .sample("transmittance_tex", refs.transmittance)
      .sample("source_tex", refs.source)
      .read("sky_views", refs.sky_views)
      .write("out_sky_view", refs.sky_view)
      .record([this, count](gpu::Commands& cmd) {
        cmd.bind(sky_view_).dispatch_threads(u32(shared::kSkyAzimuths), u32(shared::kSkyRows), count);
      });
  return refs;
}

void AtmosphereTables::bind(FrameGraph::PassBuilder& pass, const Refs& refs, Views views) {
  pass.uniform("atmosphere", refs.params)
      .sample("transmittance_tex", refs.transmittance)
      .sample("irradiance_tex", refs.irradiance)
      .sample("source_tex", refs.source)
      .sample("mirror_tex", refs.mirror)
      .sample("sky_view_tex", refs.sky_view);
  if (views == Views::of_a_frame)
    pass.uniform("sky_views", refs.sky_views);
  else
    pass.read("sky_views", refs.sky_views);
}

}  // namespace nepho
