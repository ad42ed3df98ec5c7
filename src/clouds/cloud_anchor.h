#pragma once
#include <array>
#include <glm/mat3x3.hpp>

#include "clouds/clouds_shared.h"
#include "scene/cloud_params.h"

namespace nepho {

/// How the noise of one domain lies on the Earth, in double (shared::CloudDomain holds it in float).
struct CloudLattice {
  glm::dmat3 uvw_from_ecef{1.0};  ///< 1/m
  glm::dvec3 start{0.0};          ///< coordinate of the Earth's centre in window 0, in periods
  double texel_m = 1.0;
};
using CloudLattices = std::array<CloudLattice, shared::kCloudDomains>;

/// Texels along a side of the textures that lattices are read from.
struct CloudTexels {
  uint32_t field = 128, cells = 128, shape = 128, detail = 32, turbulence = 64, tile = 1;
};

/// The lattices of all domains; `layers` are the drawing layers in the shader's order.
CloudLattices make_cloud_lattices(const CloudParams& params, const std::vector<CloudLayer>& layers,
                                  const CloudTexels& texels);

/// A pattern lives for one window and is carried by the wind from its middle on; around the ends two overlap.
inline constexpr double kWindow_s = 12.0 * 3600.0;
inline constexpr double kWindowOverlap_s = 1200.0;  ///< centred on the ends

/// The patterns of a moment (seconds since 2000-01-01T00:00Z): windows, ages since their middles, weights.
struct CloudPhases {
  uint32_t count = 1;  ///< 2 within an overlap
  std::array<int64_t, 2> window{};
  std::array<double, 2> age_s{};
  std::array<double, 2> weight{1.0, 0.0};  ///< squares add to 1
};
CloudPhases cloud_phases(double time_s);

/// What shaders need of camera and clock. Everything is reduced modulo a period in double.
shared::CloudAnchor make_cloud_anchor(const CloudLattices& lattices, const CloudParams& params,
                                      const glm::dvec3& camera_ecef_m, double time_s);

}  // namespace nepho
