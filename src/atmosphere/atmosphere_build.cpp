#include "atmosphere/atmosphere_build.h"

#include <algorithm>

#include "atmosphere/atmosphere_cache.h"
#include "atmosphere/incident.comp.h"
#include "atmosphere/irradiance.comp.h"
#include "atmosphere/sky_tables.comp.h"
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
constexpr uint64_t kBuildVersion = 1;

/// Heights per submission of the long steps: an interactive frame or a watchdog must not wait for all of them.
constexpr int kHeightsPerStep = 8;

class Builder {
 public:
  Builder(gpu::Device& device, const shared::AtmosphereUniform& air, const AtmosphereTableTargets& targets)
      : air_(air),
        to_(targets),
        executor_(device),
        transmittance_(device, {"atmosphere.transmittance", transmittance_comp}),
        incident_(device, {"atmosphere.incident", incident_comp}),
        irradiance_(device, {"atmosphere.irradiance", irradiance_comp}),
        source_(device, {"atmosphere.source", source_comp}),
        sky_(device, {"atmosphere.sky_tables", sky_tables_comp}) {
    const Extent3D source_extent(u32(shared::kAirNu * shared::kAirMuS), u32(shared::kSourceMu), u32(shared::kAirR));
    order_source_ = device.create_image({"atmosphere.order_source", source_extent, Format::rgba32f});
    sum_source_ = device.create_image({"atmosphere.sum_source", source_extent, Format::rgba32f});
    order_irradiance_ =
        device.create_image({"atmosphere.order_irradiance", targets.irradiance.desc().extent, Format::rgba32f});
    incident_light_ =
        device.create_buffer({"atmosphere.incident_light",
                              uint64_t{16} * shared::kAirR * shared::kAirMuS * shared::kIncidentDirections, false});
  }

  void transmittance() {
    run([&](FrameGraph& g, BufferRef air) {
      g.pass("atmosphere.transmittance")
          .uniform("atmosphere", air)
          .write("out_transmittance", g.import(to_.transmittance))
          .record([this](gpu::Commands& cmd) {
            cmd.bind(transmittance_).dispatch_threads(u32(shared::kTransmittanceMu), u32(shared::kTransmittanceR));
          });
    });
  }

  /// Light of `order` that arrives everywhere, and its sums over the hemispheres.
  void incident(int order) {
    run([&](FrameGraph& g, BufferRef air) {
      const BufferRef light = g.import(incident_light_);
      const ImageRef order_irradiance = g.import(order_irradiance_);
      g.pass("atmosphere.incident")
          .uniform("atmosphere", air)
          .sample("transmittance_tex", g.import(to_.transmittance))
          .sample("irradiance_tex", order_irradiance)
          .sample("source_tex", g.import(order_source_))
          .write("incident", light)
          .record([this, order](gpu::Commands& cmd) {
            cmd.bind(incident_)
                .push(OrderPush{order})
                .dispatch_threads(u32(shared::kIncidentDirections), u32(shared::kAirMuS), u32(shared::kAirR));
          });
      g.pass("atmosphere.irradiance")
          .uniform("atmosphere", air)
          .read("incident", light)
          .write("out_order", order_irradiance)
          .read_write("sum", g.import(to_.irradiance))
          .record([this, order](gpu::Commands& cmd) {
            cmd.bind(irradiance_).push(OrderPush{order}).dispatch_threads(u32(shared::kAirMuS), u32(shared::kAirR));
          });
    });
  }

  /// The incident light scattered once more.
  void source(int order) {
    for_height_steps([&](int first, int count) {
      run([&](FrameGraph& g, BufferRef air) {
        g.pass("atmosphere.source")
            .uniform("atmosphere", air)
            .read("incident", g.import(incident_light_))
            .write("out_order", g.import(order_source_))
            .read_write("sum", g.import(sum_source_))
            .record([this, order, first, count](gpu::Commands& cmd) {
              cmd.bind(source_)
                  .push(StepPush{order, first})
                  .dispatch_threads(u32(shared::kAirNu * shared::kSourceMu), u32(shared::kAirMuS), u32(count));
            });
      });
    });
  }

  void sky_tables(int orders) {
    for_height_steps([&](int first, int count) {
      run([&](FrameGraph& g, BufferRef air) {
        g.pass("atmosphere.sky_tables")
            .uniform("atmosphere", air)
            .sample("transmittance_tex", g.import(to_.transmittance))
            .sample("source_tex", g.import(sum_source_))
            .write("out_rayleigh", g.import(to_.rayleigh))
            .write("out_mie", g.import(to_.mie))
            .write("out_multiple", g.import(to_.multiple))
            .record([this, orders, first, count](gpu::Commands& cmd) {
              cmd.bind(sky_)
                  .push(StepPush{orders, first})
                  .dispatch_threads(u32(shared::kAirNu * shared::kAirMuS), u32(shared::kMultipleRows), u32(count));
            });
      });
    });
  }

  std::vector<std::pair<std::string, double>> times;

 private:
  template <typename F>
  void for_height_steps(F&& f) {
    for (int first = 0; first < shared::kAirR; first += kHeightsPerStep)
      f(first, std::min(kHeightsPerStep, shared::kAirR - first));
  }
  template <typename F>
  void run(F&& declare) {
    FrameGraph graph;
    declare(graph, graph.constants("atmosphere", air_));
    executor_.run(graph);
    for (const gpu::PassTiming& t : executor_.timings()) times.emplace_back(t.name, t.gpu_ms);
  }

  shared::AtmosphereUniform air_;
  AtmosphereTableTargets to_;
  gpu::GraphExecutor executor_;
  gpu::ComputePipeline transmittance_, incident_, irradiance_, source_, sky_;
  gpu::Image order_source_, sum_source_, order_irradiance_;
  gpu::Buffer incident_light_;
};

}  // namespace

std::vector<std::pair<std::string, double>> build_atmosphere_tables(gpu::Device& device,
                                                                    const shared::AtmosphereUniform& air, int orders,
                                                                    const AtmosphereTableTargets& targets) {
  Builder builder(device, air, targets);
  builder.transmittance();
  for (int order = 1; order <= orders; ++order) {
    builder.incident(order);
    if (order < orders) builder.source(order + 1);
  }
  builder.sky_tables(orders);
  return builder.times;
}

uint64_t atmosphere_build_hash() {
  uint64_t hash = hash_bytes(std::as_bytes(std::span(&kBuildVersion, 1)));
  for (const std::span<const uint32_t> spirv :
       {std::span<const uint32_t>(transmittance_comp), std::span<const uint32_t>(incident_comp),
        std::span<const uint32_t>(irradiance_comp), std::span<const uint32_t>(source_comp),
        std::span<const uint32_t>(sky_tables_comp)})
    hash = hash_bytes(std::as_bytes(spirv), hash);
  return hash;
}

}  // namespace nepho
