#pragma once
#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "clouds/clouds.h"
#include "gpu/device.h"

namespace nepho {

/// A homogeneous layer without end sideways, with a Henyey-Greenstein phase function, over black ground and without
/// air, under a sun that gives irradiance 1 to a plane that faces it.
struct Slab {
  double tau = 1.0;                       ///< vertical optical thickness, > 0
  double single_scattering_albedo = 1.0;  ///< 0..1
  double g = 0.0;                         ///< mean cosine of the scattering angle, (-1, 1)
  double mu0 = 1.0;                       ///< cosine of the sun's zenith angle, (0, 1]
  double droplet_diameter_um = 0.0;       ///< > 0: mie_fit() of these droplets in place of Henyey-Greenstein and g
  bool operator==(const Slab&) const = default;
};

/// A direction in which light leaves a slab.
struct SlabDirection {
  bool up = true;        ///< out of the top, or out of the bottom
  double mu = 1.0;       ///< cosine to the vertical, > 0
  double phi_deg = 0.0;  ///< azimuth between the light's travel and the horizontal direction of sunlight's; 0 forward
  /// As in tables: up_mu0.1_phi0.
  std::string name() const;
  bool operator==(const SlabDirection&) const = default;
};

inline constexpr size_t kSlabDirections = 36;
/// The directions of tables, in their order: up, then down; mu 0.1, 0.3, 0.5, 0.7, 0.9, 1; phi 0, 90, 180.
const std::array<SlabDirection, kSlabDirections>& slab_directions();

/// What leaves a slab.
struct SlabLight {
  double reflectance = 0.0;            ///< flux out of the top / flux that arrives on it
  double transmittance_direct = 0.0;   ///< flux of unscattered sunlight out of the bottom / flux on the top
  double transmittance_diffuse = 0.0;  ///< of scattered light
  /// In slab_directions(), per irradiance of a plane that faces the sun, 1/sr.
  std::array<double, kSlabDirections> radiance{};
};

/// A way to find the light of slabs.
class SlabSolver {
 public:
  virtual ~SlabSolver() = default;
  virtual std::vector<SlabLight> solve(std::span<const Slab> slabs) = 0;
};

/// The slab as a layer of a scene: even, flat, at the equator, thin against the Earth's radius.
CloudParams slab_clouds(const Slab& slab);
/// Geodetic heights of its faces, m.
inline constexpr double kSlabBase_m = 500.0, kSlabTop_m = 750.0;
/// The constants of `clouds`, made with slab_clouds() of any slab, as they would be for another one. Making Clouds
/// anew takes seconds.
shared::CloudConstants slab_constants(const Clouds& clouds, const Slab& slab);

/// The fast path: CloudMarchPass draws the layer in small frames from just above it and just below it. Radiances are
/// means over half a tenth of a degree to all sides; fluxes are sums over pictures of the hemisphere.
class MarchedSlabs : public SlabSolver {
 public:
  /// `multiple_scattering`: as CloudParams::multiple_scattering. `face_px`: pixels along a cube face of those pictures,
  /// a multiple of 8; 0: as many as each slab needs.
  explicit MarchedSlabs(gpu::Device& device, const std::string& multiple_scattering = "cells", uint32_t face_px = 0);
  ~MarchedSlabs() override;
  std::vector<SlabLight> solve(std::span<const Slab> slabs) override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace nepho
