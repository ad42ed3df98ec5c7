#include "atmosphere/sky_view.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace nepho {

static_assert(sizeof(shared::SkyView) == 22 * 4);

glm::uvec2 sky_view_extent(int count) {
  const int wide = std::min(count, shared::kSkyViewsWide);
  const int high = (count + shared::kSkyViewsWide - 1) / shared::kSkyViewsWide;
  return {static_cast<unsigned>(wide * shared::kSkyAzimuths),
          static_cast<unsigned>(shared::kSkyParts * high * shared::kSkyRows)};
}

bool has_sky_view(const shared::AtmosphereUniform& air, const shared::PlanetView& planet) {
  return shared::scaled_height_from_f(planet, planet.camera_f_m2) <= air.sky_view_top_m;
}

shared::SkyView make_sky_view(const shared::AtmosphereUniform& air, const shared::PlanetView& planet,
                              const glm::vec3& camera_up, const glm::vec3& light_dir, int index, int count) {
  shared::SkyView view{};
  // The scaled vertical and the light's azimuth around it.
  const glm::dvec3 up = glm::normalize(glm::dvec3(planet.camera_q_m));
  const glm::dvec3 light(light_dir.x, light_dir.y, light_dir.z * planet.a_over_b);
  glm::dvec3 forward = light - up * glm::dot(light, up);
  if (glm::length(forward) < 1e-6)
    forward = glm::cross(up, std::abs(up.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0));
  view.up = glm::vec3(up);
  view.forward = glm::vec3(glm::normalize(forward));
  view.light_dir = light_dir;
  view.a_over_b = planet.a_over_b;
  view.mu_s = std::clamp(glm::dot(camera_up, light_dir), -1.0f, 1.0f);
  view.h = std::clamp(shared::scaled_height_from_f(planet, planet.camera_f_m2), 0.0f, air.top_m);
  const double R = air.radius_m, h = view.h;
  view.side = glm::vec3(glm::cross(up, glm::dvec3(view.forward)));
  const double dip_rad = std::asin(std::min(1.0, std::sqrt(h * (2.0 * R + h)) / (R + h)));
  view.horizon_t = static_cast<float>(std::tan(0.5 * dip_rad));
  // The corner between the two maps of rows falls on a texel.
  constexpr float last_row = shared::kSkyRows - 1;
  view.split = std::max(std::round(shared::sky_view_split(static_cast<float>(dip_rad)) * last_row), 1.0f) / last_row;

  const glm::vec2 size(sky_view_extent(count));
  const glm::vec2 first(static_cast<float>(index % shared::kSkyViewsWide * shared::kSkyAzimuths),
                        static_cast<float>(index / shared::kSkyViewsWide * shared::kSkyParts * shared::kSkyRows));
  view.uv_origin = (first + 0.5f) / size;
  view.uv_span = glm::vec2(shared::kSkyAzimuths - 1, shared::kSkyRows - 1) / size;
  view.part_v = static_cast<float>(shared::kSkyRows) / size.y;
  return view;
}

}  // namespace nepho
