#include "geo/planet_view.h"

#include <glm/geometric.hpp>

namespace nepho {

static_assert(sizeof(shared::PlanetView) == 48);

shared::PlanetView make_planet_view(const dvec3& camera_ecef_m, const Ellipsoid& ellipsoid) {
  const double a = ellipsoid.a_m;
  const dvec3 q(camera_ecef_m.x, camera_ecef_m.y, camera_ecef_m.z * ellipsoid.a_over_b());
  const double q_length = glm::length(q);
  shared::PlanetView view{};
  view.camera_q_m = vec3(q);
  view.camera_q_low_m = vec3(q - dvec3(view.camera_q_m));
  view.a_m = static_cast<float>(a);
  view.a_over_b = static_cast<float>(ellipsoid.a_over_b());
  view.stretch = static_cast<float>((a - ellipsoid.b_m) / ellipsoid.b_m);
  view.camera_f_m2 = static_cast<float>((q_length - a) * (q_length + a));
  view.camera_height_m = static_cast<float>(geodetic_from_ecef(camera_ecef_m, ellipsoid).height_m);
  return view;
}

}  // namespace nepho
