#include "scene/atmosphere_params.h"

#include "base/error.h"

namespace nepho {

AtmosphereParams AtmosphereParams::bruneton_demo() {
  AtmosphereParams demo;
  demo.equatorial_radius_m = 6360000.0;
  demo.polar_radius_m = 6360000.0;
  demo.mie.scattering_per_m = glm::dvec3(3.996e-6);  // 0.9 of the extinction, 5.328e-3 / 1200 m
  demo.mie.extinction_per_m = glm::dvec3(4.44e-6);
  return demo;
}

AtmosphereParams resolved(const AtmosphereParams& params) {
  AtmosphereParams out = params;
  MieParams& mie = out.mie;
  if (mie.optical_depth && mie.visibility_m)
    throw fail(ErrorKind::usage, "atmosphere.mie: optical_depth and visibility_m are both given; keep one of the two");
  if (mie.optical_depth || mie.visibility_m) {
    const double now = mie.extinction_per_m[1];
    double wanted = 0.0;
    if (mie.optical_depth) {
      wanted = *mie.optical_depth / mie.scale_height_m;
    } else {
      const double total = 3.912 / *mie.visibility_m, gas = out.rayleigh.scattering_per_m[1];
      if (!(total >= gas))
        throw fail(ErrorKind::usage, "atmosphere.mie.visibility_m: {} is more than gas alone allows; at most {:.0f}",
                   *mie.visibility_m, 3.912 / gas);
      wanted = total - gas;
    }
    if (!(now > 0.0) && wanted > 0.0)
      throw fail(ErrorKind::usage,
                 "atmosphere.mie.{}: there is no spectrum to scale, extinction_per_m is 0 at 550 nm; give it a value",
                 mie.optical_depth ? "optical_depth" : "visibility_m");
    const double scale = now > 0.0 ? wanted / now : 0.0;
    mie.extinction_per_m *= scale;
    mie.scattering_per_m *= scale;
    mie.optical_depth.reset();
    mie.visibility_m.reset();
  }
  if (out.ozone.column_du) {
    // Bruneton 2017: 300 DU are 6.497e-7, 1.881e-6, 8.502e-8 1/m at the top of a tent of half width 15 km.
    const glm::dvec3 per_du_m = OzoneParams{}.absorption_per_m * (OzoneParams{}.half_width_m / 300.0);
    out.ozone.absorption_per_m = per_du_m * (*out.ozone.column_du / out.ozone.half_width_m);
    out.ozone.column_du.reset();
  }
  return out;
}

}  // namespace nepho
