#include "scene/atmosphere_params.h"

namespace nepho {

AtmosphereParams AtmosphereParams::bruneton_demo() {
  AtmosphereParams demo;
  demo.equatorial_radius_m = 6360000.0;
  demo.polar_radius_m = 6360000.0;
  return demo;
}

}  // namespace nepho
