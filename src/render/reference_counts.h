#pragma once
#include <cstdint>

namespace nepho {

/// Work that a reference did so far.
struct ReferenceCounts {
  uint64_t paths = 0, vertices = 0, density_reads = 0, moves = 0, overruns = 0;
  double noise = 0.0;                     ///< ReferenceProgress::noise at the end
  double trace_ms = 0.0, shade_ms = 0.0;  ///< by GPU timestamps
};

}  // namespace nepho
