#include "astro/time_scales.h"

#include <erfa.h>

#include <algorithm>

#include "base/error.h"

namespace nepho {

namespace {
constexpr double kTtMinusTai_s = 32.184;
constexpr int kFirstLeapSecondYear = 1972;
constexpr int kLeapSecondsKnownUntil = 2027;  // the first year of which nothing is announced
constexpr double kFadeYears = 30.0;

double leap_seconds_s(const CalendarDate& date) {
  double tai_minus_utc_s = 0.0;
  const int status = eraDat(date.year, date.month, date.day, 0.0, &tai_minus_utc_s);
  NEPHO_ASSERT_OP(status, >=, 0);  // 1, a year later than ERFA's release foresaw, keeps the last value
  return tai_minus_utc_s;
}
}  // namespace

double espenak_meeus_delta_t_s(double y) {
  if (y < 1920.0) {
    const double t = y - 1900.0;
    return -2.79 + t * (1.494119 + t * (-0.0598939 + t * (0.0061966 - t * 0.000197)));
  }
  if (y < 1941.0) {
    const double t = y - 1920.0;
    return 21.20 + t * (0.84493 + t * (-0.076100 + t * 0.0020936));
  }
  if (y < 1961.0) {
    const double t = y - 1950.0;
    return 29.07 + t * (0.407 + t * (-1.0 / 233.0 + t / 2547.0));
  }
  if (y < 1986.0) {
    const double t = y - 1975.0;
    return 45.45 + t * (1.067 + t * (-1.0 / 260.0 - t / 718.0));
  }
  if (y < 2050.0) {
    const double t = y - 2000.0;
    return 62.92 + t * (0.32217 + t * 0.005589);
  }
  const double u = (y - 1820.0) / 100.0;
  return -20.0 + 32.0 * u * u - 0.5628 * (2150.0 - y);
}

double tt_minus_ut_s(const UtcInstant& utc) {
  const CalendarDate date = calendar_from_day(utc.day);
  const double year = utc.decimal_year();
  if (date.year < kFirstLeapSecondYear) return espenak_meeus_delta_t_s(year);
  if (date.year < kLeapSecondsKnownUntil) return kTtMinusTai_s + leap_seconds_s(date);
  const double joint = kLeapSecondsKnownUntil;
  const double offset_s =
      kTtMinusTai_s + leap_seconds_s({kLeapSecondsKnownUntil - 1, 12, 31}) - espenak_meeus_delta_t_s(joint);
  const double fade = std::clamp(1.0 - (year - joint) / kFadeYears, 0.0, 1.0);
  return espenak_meeus_delta_t_s(year) + fade * offset_s;
}

}  // namespace nepho
