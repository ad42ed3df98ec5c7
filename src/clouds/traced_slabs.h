#pragma once
#include "clouds/slab_probe.h"

namespace nepho {

/// What leaves a slab by chance: an estimate and its standard errors.
struct TracedSlab {
  SlabLight light, error;
  uint64_t paths = 0;
};

/// The truth, as pictures of quality reference have it: PathTracer follows rays that look at the layer from above and
/// from below.
class TracedSlabs : public SlabSolver {
 public:
  /// `noise`: relative standard error wanted of radiances (or 0.005 mu0 of it, 1/sr, where that is larger); 0: 2 %.
  /// Of fluxes 0.15 of it relative, or 0.05 of it absolute. Rows that want too many paths get what there is. A slab's
  /// light depends on it and on `seed` alone.
  explicit TracedSlabs(gpu::Device& device, double noise = 0.0, uint32_t seed = 0);
  ~TracedSlabs() override;
  std::vector<SlabLight> solve(std::span<const Slab> slabs) override;
  TracedSlab trace(const Slab& slab);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace nepho
