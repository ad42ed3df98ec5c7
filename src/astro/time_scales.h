#pragma once
#include "astro/utc_time.h"

namespace nepho {

/// TT - UT1 in seconds, with UT1 taken as UTC (they differ by 0.9 s at most: 13.5 arc seconds of Earth rotation).
/// 1972..2026: 32.184 s + TAI - UTC, from the leap seconds in ERFA. Before: Espenak & Meeus 2006. After: Espenak &
/// Meeus, joined to the last known value by a difference (-6.5 s) that fades out until 2057, so that nothing jumps in
/// between.
double tt_minus_ut_s(const UtcInstant& utc);

/// The polynomials of Espenak & Meeus 2006, s, for 1900..2150 without 1986..2005 (where leap seconds are known).
double espenak_meeus_delta_t_s(double decimal_year);

}  // namespace nepho
