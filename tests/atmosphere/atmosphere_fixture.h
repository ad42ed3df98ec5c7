#pragma once
#include <cstdlib>
#include <glm/geometric.hpp>
#include <memory>
#include <vector>

#include "atmosphere/atmosphere_probe.h"
#include "geo/planet_view.h"
#include "gpu/gpu_fixture.h"

namespace nepho {

/// Asks the atmosphere's lookup functions on the device. Tables stay in a cache of the build tree.
class AtmosphereFixture : public GpuFixture {
 public:
  using Case = AtmosphereProbe::Case;
  using Answer = AtmosphereProbe::Answer;

  std::vector<Answer> ask(const AtmosphereParams& params, uint32_t kind, const std::vector<Case>& cases) {
    return probe(params).ask(kind, cases);
  }
  const AtmosphereTables& tables(const AtmosphereParams& params) { return probe(params).tables(); }

  AtmosphereProbe& probe(const AtmosphereParams& params) {
    static std::vector<std::unique_ptr<AtmosphereProbe>> kept;
    for (const auto& p : kept)
      if (p->tables().params() == params) return *p;
    ::setenv("NEPHO_CACHE", NEPHO_TEST_CACHE, 1);
    const auto tables = std::make_shared<const AtmosphereTables>(device, params);
    kept.push_back(std::make_unique<AtmosphereProbe>(device, tables));
    double gpu_ms = 0.0;
    for (const auto& [step, ms] : tables->step_ms()) gpu_ms += ms;
    MESSAGE("tables of " << params.scattering_orders << " orders, " << params.spectral << ": " << tables->build_ms()
                         << " ms, " << gpu_ms << " ms of them on " << device.info().name
                         << ", from cache: " << tables->came_from_cache());
    return *kept.back();
  }
};

/// The planet of the oracles.
inline AtmosphereParams bruneton_demo(int orders) {
  AtmosphereParams p = AtmosphereParams::bruneton_demo();
  p.spectral = "fast";  // the oracles' own wavelengths
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
