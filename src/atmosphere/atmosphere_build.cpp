#include "atmosphere/atmosphere_build.h"

#include <algorithm>
#include <cmath>

#include "atmosphere/atmosphere_cache.h"
#include "atmosphere/incident.comp.h"
#include "atmosphere/irradiance.comp.h"
#include "atmosphere/mirror.comp.h"
#include "atmosphere/source.comp.h"
#include "atmosphere/transmittance.comp.h"
#include "gpu/commands.h"
#include "gpu/graph_executor.h"
#include "gpu/pipeline.h"

namespace nepho {

namespace {

struct StepPush {
  int32_t order;
  int32_t first_slice;
};
struct OrderPush {
  int32_t order;
};

constexpr uint32_t u32(int n) { return static_cast<uint32_t>(n); }

/// Raise it when the order or meaning of the steps changes: old cache files are then no longer found.
constexpr uint64_t kBuildVersion = 2;

/// Heights per submission of the long steps: an interactive frame or a watchdog must not wait for all of them.
constexpr int kHeightsPerStep = 4;

constexpr uint64_t kVec3Bytes = 12;
constexpr uint64_t kCells = uint64_t{shared::kAirR} * shared::kAirMuS;

}  // namespace

class AtmosphereBuild::Steps {
 public:
  Steps(gpu::Device& device, const AtmosphereConstants& air, const AtmosphereTableTargets& targets)
      : air_(air.data),
        to_(targets),
        executor_(device),
        transmittance_(device, {"atmosphere.transmittance", transmittance_comp}),
        first_incident_(device, {"atmosphere.incident.1", incident_comp, {u32(air.spectral_groups), 1u}}),
        incident_(device, {"atmosphere.incident", incident_comp, {u32(air.spectral_groups), 0u}}),
        irradiance_(device, {"atmosphere.irradiance", irradiance_comp, {u32(air.spectral_groups)}}),
        source_(device, {"atmosphere.source", source_comp, {u32(air.spectral_groups)}}),
        mirror_(device, {"atmosphere.mirror", mirror_comp, {u32(air.spectral_groups)}}) {
    const uint64_t light_bytes = kVec3Bytes * static_cast<uint64_t>(air.spectral_groups);
    order_source_ = device.create_image({"atmosphere.order_source", targets.source.desc().extent, Format::rgba32f});
    order_irradiance_ = device.create_buffer({"atmosphere.order_irradiance", light_bytes * shared::kAirMuS, false});
    irradiance_sum_ = device.create_buffer({"atmosphere.irradiance_sum", light_bytes * kCells * 3, false});
    moments_ = device.create_buffer({"atmosphere.moments", light_bytes * kCells * 4, false});
    incident_light_ =
        device.create_buffer({"atmosphere.incident_light", light_bytes * kCells * shared::kIncidentDirections, false});
    source_sum_ = device.create_buffer(
        {"atmosphere.source_sum", light_bytes * kCells * shared::kSourceMu * shared::kAirNu, false});
    no_light(device);
  }

  void transmittance() {
    run([&](FrameGraph& g, BufferRef air) {
      g.pass("atmosphere.transmittance")
          .uniform("atmosphere", air)
          .write("out_columns", g.import(to_.transmittance))
          .record([this](gpu::Commands& cmd) {
            cmd.bind(transmittance_).dispatch_threads(u32(shared::kColumnMu), u32(shared::kColumnR));
          });
    });
  }

  /// Light of `order` that arrives at some of the heights.
  void incident(int order, int first, int count) {
    run([&](FrameGraph& g, BufferRef air) {
      g.pass("atmosphere.incident")
          .uniform("atmosphere", air)
          .sample("transmittance_tex", g.import(to_.transmittance))
          .read("order_irradiance", g.import(order_irradiance_))
          .sample("source_tex", g.import(order_source_))
          .write("incident", g.import(incident_light_))
          .record([this, order, first, count](gpu::Commands& cmd) {
            cmd.bind(order == 1 ? first_incident_ : incident_)
                .push(StepPush{order, first})
                .dispatch_threads(u32(shared::kIncidentDirections), u32(shared::kAirMuS), u32(count));
          });
    });
  }

  /// Its sums over the hemispheres.
  void irradiance(int order) {
    run([&](FrameGraph& g, BufferRef air) {
      g.pass("atmosphere.irradiance")
          .uniform("atmosphere", air)
          .read("incident", g.import(incident_light_))
          .write("order_irradiance", g.import(order_irradiance_))
          .write("moments", g.import(moments_))
          .read_write("irradiance_sum", g.import(irradiance_sum_))
          .write("out_irradiance", g.import(to_.irradiance))
          .record([this, order](gpu::Commands& cmd) {
            cmd.bind(irradiance_).push(OrderPush{order}).dispatch_threads(u32(shared::kAirMuS), u32(shared::kAirR));
          });
    });
  }

  /// The incident light scattered once more, at some of the heights.
  void source(int order, int first, int count) {
    run([&](FrameGraph& g, BufferRef air) {
      g.pass("atmosphere.source")
          .uniform("atmosphere", air)
          .read("incident", g.import(incident_light_))
          .read("moments", g.import(moments_))
          .read_write("source_sum", g.import(source_sum_))
          .write("out_order", g.import(order_source_))
          .write("out_source", g.import(to_.source))
          .record([this, order, first, count](gpu::Commands& cmd) {
            cmd.bind(source_)
                .push(StepPush{order, first})
                .dispatch_threads(u32(shared::kAirNu * shared::kSourceMu), u32(shared::kAirMuS), u32(count));
          });
    });
  }

  void mirror() {
    run([&](FrameGraph& g, BufferRef air) {
      g.pass("atmosphere.mirror")
          .uniform("atmosphere", air)
          .sample("transmittance_tex", g.import(to_.transmittance))
          .sample("source_tex", g.import(to_.source))
          .write("out_mirror", g.import(to_.mirror))
          .record([this](gpu::Commands& cmd) {
            cmd.bind(mirror_).dispatch_threads(u32(shared::kAirNu * shared::kAirMuS), u32(shared::kMirrorMu));
          });
    });
  }

  std::vector<std::pair<std::string, double>> times;

 private:
  /// Single scattering has no source function: the coefficients of the least light.
  void no_light(gpu::Device& device) {
    glm::vec4 none(0.0f);
    for (const shared::SpectralGroup& group : air_.spectrum)
      none += group.fit * glm::vec3(std::log(shared::kLeastLight));
    const Extent3D e = to_.source.desc().extent;
    const std::vector<glm::vec4> texels(size_t{e.width} * e.height * e.depth, none);
    const gpu::ImageUpload uploads[] = {{&to_.source, std::as_bytes(std::span(texels)), 0, 0},
                                        {&order_source_, std::as_bytes(std::span(texels)), 0, 0}};
    device.upload(uploads);
  }
  template <typename F>
  void run(F&& declare) {
    FrameGraph graph;
    declare(graph, graph.constants("atmosphere", air_));
    executor_.run(graph);
    for (const gpu::PassTiming& t : executor_.timings()) times.emplace_back(t.name, t.gpu_ms);
  }

  shared::AtmosphereData air_;
  AtmosphereTableTargets to_;
  gpu::GraphExecutor executor_;
  gpu::ComputePipeline transmittance_, first_incident_, incident_, irradiance_, source_, mirror_;
  gpu::Image order_source_;
  gpu::Buffer order_irradiance_, irradiance_sum_, moments_, incident_light_, source_sum_;
};

AtmosphereBuild::AtmosphereBuild(gpu::Device& device, const AtmosphereConstants& air, int orders,
                                 const AtmosphereTableTargets& to)
    : passes_(std::make_unique<Steps>(device, air, to)) {
  Steps* const p = passes_.get();
  todo_.push_back([p] { p->transmittance(); });
  const auto for_heights = [&](auto step) {
    for (int first = 0; first < shared::kAirR; first += kHeightsPerStep)
      todo_.push_back([=] { step(first, std::min(kHeightsPerStep, shared::kAirR - first)); });
  };
  for (int order = 1; order <= orders; ++order) {
    for_heights([=](int first, int count) { p->incident(order, first, count); });
    todo_.push_back([=] { p->irradiance(order); });
    if (order < orders) for_heights([=](int first, int count) { p->source(order + 1, first, count); });
  }
  todo_.push_back([p] { p->mirror(); });
}

AtmosphereBuild::~AtmosphereBuild() = default;

bool AtmosphereBuild::step() {
  if (next_ == steps()) return false;
  todo_[static_cast<size_t>(next_++)]();
  return true;
}

const std::vector<std::pair<std::string, double>>& AtmosphereBuild::times() const { return passes_->times; }

uint64_t atmosphere_build_hash() {
  uint64_t hash = hash_bytes(std::as_bytes(std::span(&kBuildVersion, 1)));
  for (const std::span<const uint32_t> spirv :
       {std::span<const uint32_t>(transmittance_comp), std::span<const uint32_t>(incident_comp),
        std::span<const uint32_t>(irradiance_comp), std::span<const uint32_t>(source_comp),
        std::span<const uint32_t>(mirror_comp)})
    hash = hash_bytes(std::as_bytes(spirv), hash);
  return hash;
}

}  // namespace nepho
