#include <cmath>
#include <cstring>

#include "clouds/slab_probe.h"
#include "gpu/gpu_fixture.h"

namespace nepho {
namespace {

struct SlabFixture : GpuFixture {
  MarchedSlabs march{device, "octaves"};  // the same every time, and quick
  SlabLight solve(const Slab& slab) { return march.solve({&slab, 1}).front(); }
};

TEST_CASE("gpu: a slab lets exp(-tau / mu0) of the sunlight through, and nothing where that is below 0.001") {
  SlabFixture f;
  // The march's steps tile the layer to 1 / 125 of its thickness, at random by pixel: 64 pixels are within 0.1 %.
  for (const auto& [tau, mu0] : {std::pair{0.5, 0.7}, {1.0, 1.0}, {2.0, 0.5}, {1.0, 0.2}}) {
    CAPTURE(tau);
    CAPTURE(mu0);
    const double expected = std::exp(-tau / mu0);
    CHECK(f.solve({.tau = tau, .mu0 = mu0}).transmittance_direct == doctest::Approx(expected).epsilon(0.005));
  }
  CHECK(f.solve({.tau = 16.0, .mu0 = 0.5}).transmittance_direct == 0.0);
}

TEST_CASE("gpu: a slab that only absorbs sends nothing") {
  SlabFixture f;
  const SlabLight light = f.solve({.tau = 1.0, .single_scattering_albedo = 0.0, .g = 0.5, .mu0 = 0.5});
  CHECK(light.reflectance == 0.0);
  CHECK(light.transmittance_diffuse == 0.0);
  for (const double radiance : light.radiance) CHECK(radiance == 0.0);
  CHECK(light.transmittance_direct == doctest::Approx(std::exp(-2.0)).epsilon(0.005));
}

TEST_CASE("gpu: under a sun in the zenith the azimuth makes no difference; nor does it straight up and down") {
  SlabFixture f;
  const SlabLight high = f.solve({.tau = 2.0, .g = 0.85, .mu0 = 1.0}),
                  low = f.solve({.tau = 2.0, .g = 0.85, .mu0 = 0.5});
  for (size_t i = 0; i < kSlabDirections; i += 3) {
    CAPTURE(slab_directions()[i].name());
    const bool vertical = slab_directions()[i].mu == 1.0;
    for (const size_t other : {i + 1, i + 2}) {
      CHECK(high.radiance[other] == doctest::Approx(high.radiance[i]).epsilon(0.003));  // frames of 0.1 degrees
      if (vertical)
        CHECK(low.radiance[other] == doctest::Approx(low.radiance[i]).epsilon(0.003));
      else if (slab_directions()[i].up == false && other == i + 2)
        CHECK(low.radiance[other] < low.radiance[i]);
    }
  }
}

TEST_CASE("gpu: thicker slabs reflect more, absorbing ones less; isotropic ones more than forward scattering ones") {
  SlabFixture f;
  const Slab slab{.tau = 2.0, .g = 0.5, .mu0 = 0.7};
  const auto changed = [&](auto change) {
    Slab other = slab;
    change(other);
    return f.solve(other);
  };
  const SlabLight light = f.solve(slab);
  CHECK(light.reflectance > 0.05);
  CHECK(changed([](Slab& s) { s.tau = 0.5; }).reflectance < light.reflectance);  // octaves saturate at 4
  CHECK(changed([](Slab& s) { s.single_scattering_albedo = 0.9; }).reflectance < light.reflectance);
  CHECK(changed([](Slab& s) { s.single_scattering_albedo = 0.9; }).transmittance_diffuse < light.transmittance_diffuse);
  CHECK(changed([](Slab& s) { s.g = 0.0; }).reflectance > light.reflectance);
}

TEST_CASE("gpu: pictures of the hemispheres seven times as fine change fluxes by less than 0.4 %") {
  SlabFixture f;
  MarchedSlabs fine(f.device, "octaves", 64);
  for (const double mu0 : {1.0, 0.5}) {
    const Slab slab{.tau = 1.0, .g = 0.85, .mu0 = mu0};
    const SlabLight a = f.solve(slab), b = fine.solve({&slab, 1}).front();
    CHECK(a.reflectance == doctest::Approx(b.reflectance).epsilon(0.004));
    CHECK(a.transmittance_diffuse == doctest::Approx(b.transmittance_diffuse).epsilon(0.004));
  }
}

TEST_CASE("gpu: traced light gives a slab the reflectance and transmittance of the table within 10 %") {
  GpuFixture f;
  // tests/oracles/slab_dev.csv: tau 4, g 0.85, mu0 0.7: 0.312 and 0.685.
  const Slab slab{.tau = 4.0, .g = 0.85, .mu0 = 0.7};
  const SlabLight light = MarchedSlabs(f.device, "cells", 8).solve({&slab, 1}).front();
  MESSAGE("reflectance ", light.reflectance, ", diffuse transmittance ", light.transmittance_diffuse);
  CHECK(std::abs(light.reflectance / 0.312 - 1.0) < 0.1);
  CHECK(std::abs(light.transmittance_diffuse / 0.685 - 1.0) < 0.1);
}

TEST_CASE("gpu: constants of a slab are those of clouds made for it") {
  GpuFixture f;
  const Clouds any(f.device, slab_clouds({}));
  for (const Slab& slab : {Slab{.tau = 0.5, .single_scattering_albedo = 0.75, .g = -0.25, .mu0 = 1.0},
                           Slab{.tau = 64.0, .g = 0.85, .mu0 = 0.2}}) {
    const shared::CloudConstants patched = slab_constants(any, slab),
                                 made = Clouds(f.device, slab_clouds(slab)).constants();
    CHECK(std::memcmp(&patched, &made, sizeof made) == 0);
  }
}

}  // namespace
}  // namespace nepho
