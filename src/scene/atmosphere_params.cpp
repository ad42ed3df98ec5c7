#include "scene/atmosphere_params.h"

namespace nepho {

AtmosphereParams AtmosphereParams::bruneton_demo() {
  AtmosphereParams demo;
  demo.equatorial_radius_m = 6360000.0;
  demo.polar_radius_m = 6360000.0;
  demo.mie.scattering_per_m = glm::dvec3(3.996e-6);  // 0.9 of the extinction, 5.328e-3 / 1200 m
  demo.mie.extinction_per_m = glm::dvec3(4.44e-6);
  return demo;
}

}  // namespace nepho
