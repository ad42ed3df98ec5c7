#pragma once
#include <glm/vec3.hpp>

#include "atmosphere/atmosphere_shared.h"
#include "common/planet.h"

namespace nepho {

/// Whether a camera is low enough for a sky view; above, rays are integrated one by one.
bool has_sky_view(const shared::AtmosphereUniform& air, const shared::PlanetView& planet);

/// The sky view of a camera for one light (shaders/atmosphere/sky_view.comp). `camera_up` is the geodetic normal at the
/// camera, `light_dir` points to the light, both unit. `index` is its place in the image of `count` views.
shared::SkyView make_sky_view(const shared::AtmosphereUniform& air, const shared::PlanetView& planet,
                              const glm::vec3& camera_up, const glm::vec3& light_dir, int index, int count);

/// Size of the image that holds `count` views, texels.
glm::uvec2 sky_view_extent(int count);

}  // namespace nepho
