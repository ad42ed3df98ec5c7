#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace nepho {

/// Quantile of the standard normal distribution (Acklam's rational approximation, relative error 1.2e-9); -8 and 8 at 0
/// and 1.
double exact_probit(double p);

/// Coverage at a place whose weather ranks at `rank` (0..1, uniform over the globe's area): mean `mean_coverage` over
/// the globe for every contrast 0..0.95 (docs/weather.md, eq. 1). A mean of 0 or 1 is 0 or 1 everywhere.
double local_coverage(double rank, double mean_coverage, double contrast);

/// Ranks of values, 0..65535 for 0..1: for each the share of the total weight that lies below it. `values` has
/// `channels` interleaved ones, of which `channel` is ranked; `weights` one per texel.
std::vector<uint16_t> area_ranks(std::span<const float> values, uint32_t channels, uint32_t channel,
                                 std::span<const float> weights);

}  // namespace nepho
