#include "atmosphere/atmosphere_tables.h"

#include <chrono>
#include <cstring>

#include "atmosphere/atmosphere_build.h"
#include "atmosphere/atmosphere_cache.h"
#include "atmosphere/atmosphere_uniform.h"
#include "base/files.h"
#include "base/log.h"

namespace nepho {

namespace {

constexpr uint32_t u32(int n) { return static_cast<uint32_t>(n); }

template <typename T>
uint64_t hash_value(const T& value, uint64_t seed) {
  return hash_bytes(std::as_bytes(std::span(&value, 1)), seed);
}

/// Everything that the tables' bits depend on: parameters, shaders (with their sizes), device and driver.
uint64_t cache_key(const gpu::Device& device, const AtmosphereParams& p, const shared::AtmosphereUniform& uniform) {
  uint64_t key = atmosphere_build_hash();
  key = hash_value(uniform, key);
  key = hash_value(p.min_sun_zenith_cos, key);
  key = hash_value(p.scattering_orders, key);
  for (const std::string& s : {device.info().name, device.info().driver})
    key = hash_bytes(std::as_bytes(std::span(s.data(), s.size())), key);
  return key;
}

}  // namespace

AtmosphereTables::AtmosphereTables(gpu::Device& device, const AtmosphereParams& params)
    : params_(params), uniform_(make_atmosphere_uniform(params)) {
  const auto start = std::chrono::steady_clock::now();
  const uint32_t x = u32(shared::kAirNu * shared::kAirMuS), z = u32(shared::kAirR);
  transmittance_ = device.create_image(
      {"atmosphere.transmittance_tex", {u32(shared::kTransmittanceMu), u32(shared::kTransmittanceR)}, Format::rgba32f});
  irradiance_ = device.create_image({"atmosphere.irradiance_tex",
                                     {u32(shared::kAirMuS), u32(shared::kIrradianceParts * shared::kAirR)},
                                     Format::rgba32f});
  rayleigh_ = device.create_image({"atmosphere.rayleigh_tex", {x, u32(shared::kSkyMu), z}, Format::rgba16f});
  mie_ = device.create_image({"atmosphere.mie_tex", {x, u32(shared::kSkyMu), z}, Format::rgba16f});
  multiple_ = device.create_image({"atmosphere.multiple_tex", {x, u32(shared::kMultipleRows), z}, Format::rgba16f});

  const uint64_t key = cache_key(device, params, uniform_);
  const std::filesystem::path folder = cache_dir();
  if (!folder.empty()) cache_file_ = folder / fmt::format("atmosphere-{:016x}.bin", key);
  came_from_cache_ = load(device, key);
  if (!came_from_cache_) {
    log_info("computing the atmosphere's tables ({} scattering orders)", params.scattering_orders);
    step_ms_ = build_atmosphere_tables(device, uniform_, params.scattering_orders,
                                       {transmittance_, irradiance_, rayleigh_, mie_, multiple_});
    save(device, key);
  }
  build_ms_ = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

bool AtmosphereTables::load(gpu::Device& device, uint64_t key) {
  if (cache_file_.empty()) return false;
  std::vector<size_t> sizes;
  for (const gpu::Image* image : images()) {
    const ImageDesc& d = image->desc();
    sizes.push_back(size_t{d.extent.width} * d.extent.height * d.extent.depth * bytes_per_texel(d.format));
  }
  const auto blocks = load_cached_blocks(cache_file_, key, sizes);
  if (!blocks) return false;
  std::vector<gpu::ImageUpload> uploads;
  for (size_t i = 0; i < blocks->size(); ++i) uploads.push_back({images()[i], (*blocks)[i], 0, 0});
  device.upload(uploads);
  return true;
}

void AtmosphereTables::save(gpu::Device& device, uint64_t key) const {
  if (cache_file_.empty()) return;
  std::vector<std::vector<std::byte>> blocks;
  for (const gpu::Image* image : images()) blocks.push_back(device.download(*image));
  save_cached_blocks(cache_file_, key, blocks);
}

AtmosphereTables::Refs AtmosphereTables::import(FrameGraph& graph, const FrameInfo&) const {
  return {.transmittance = graph.import(transmittance_),
          .irradiance = graph.import(irradiance_),
          .rayleigh = graph.import(rayleigh_),
          .mie = graph.import(mie_),
          .multiple = graph.import(multiple_),
          .params = graph.constants("atmosphere", uniform_)};
}

void AtmosphereTables::bind(FrameGraph::PassBuilder& pass, const Refs& refs) {
  pass.uniform("atmosphere", refs.params)
      .sample("transmittance_tex", refs.transmittance)
      .sample("irradiance_tex", refs.irradiance)
      .sample("rayleigh_tex", refs.rayleigh)
      .sample("mie_tex", refs.mie)
      .sample("multiple_tex", refs.multiple);
}

}  // namespace nepho
