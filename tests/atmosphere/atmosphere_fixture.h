#pragma once
#include <cstdlib>
#include <glm/geometric.hpp>
#include <memory>
#include <vector>

#include "atmosphere/atmosphere_probe.comp.h"
#include "atmosphere/atmosphere_probe_shared.h"
#include "atmosphere/atmosphere_tables.h"
#include "geo/planet_view.h"
#include "gpu/commands.h"
#include "gpu/gpu_fixture.h"
#include "gpu/pipeline.h"

namespace nepho {

/// Asks the atmosphere's lookup functions on the device. Tables stay in a cache of the build tree.
class AtmosphereFixture : public GpuFixture {
 public:
  using Case = shared::AtmosphereCase;
  using Answer = shared::AtmosphereAnswer;

  std::vector<Answer> ask(const AtmosphereParams& params, uint32_t kind, const std::vector<Case>& cases) {
    return ask(tables(params), kind, cases);
  }
  std::vector<Answer> ask(const AtmosphereTables& tables, uint32_t kind, const std::vector<Case>& cases) {
    static const gpu::ComputePipeline pipeline(device, {"atmosphere.probe", atmosphere_probe_comp});
    struct Push {
      uint32_t kind, count;
    };
    FrameGraph graph;
    const AtmosphereTables::Refs refs = tables.import(graph, {});
    const BufferRef in = graph.constants("cases", cases);
    const BufferRef out = graph.create_buffer("answers", cases.size() * sizeof(Answer));
    graph.keep(out);
    const auto count = static_cast<uint32_t>(cases.size());
    auto pass = graph.pass("atmosphere.probe");
    AtmosphereTables::bind(pass, refs);
    pass.read("cases", in).write("answers", out).record([=](gpu::Commands& cmd) {
      cmd.bind(pipeline).push(Push{kind, count}).dispatch_threads(count);
    });
    executor.run(graph);
    return executor.read<Answer>(out);
  }

  const AtmosphereTables& tables(const AtmosphereParams& params) {
    static std::vector<std::unique_ptr<AtmosphereTables>> kept;
    for (const auto& t : kept)
      if (t->params() == params) return *t;
    ::setenv("NEPHO_CACHE", NEPHO_TEST_CACHE, 1);
    kept.push_back(std::make_unique<AtmosphereTables>(device, params));
    MESSAGE("tables of " << params.scattering_orders << " orders: " << kept.back()->build_ms()
                         << " ms, from cache: " << kept.back()->came_from_cache());
    return *kept.back();
  }
};

/// The planet of the oracles.
inline AtmosphereParams bruneton_demo(int orders) {
  AtmosphereParams p = AtmosphereParams::bruneton_demo();
  p.scattering_orders = orders;
  return p;
}

inline shared::AtmosphereCase view_case(const glm::dvec3& camera_m, const glm::dvec3& dir, const glm::dvec3& sun,
                                        bool hits_ground, const Ellipsoid& planet) {
  shared::AtmosphereCase c{};
  c.planet = make_planet_view(camera_m, planet);
  c.dir = glm::vec3(glm::normalize(dir));
  c.sun_dir = glm::vec3(glm::normalize(sun));
  const double s = planet.a_over_b();
  c.camera_up = glm::vec3(glm::normalize(glm::dvec3(camera_m.x, camera_m.y, camera_m.z * s * s)));
  c.hits_ground = hits_ground ? 1u : 0u;
  return c;
}

}  // namespace nepho
