#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace nepho {

/// A moment in UTC, split so that 1900..2100 keeps nanoseconds. Days have 86,400 s: a leap second is the second after
/// it.
struct UtcInstant {
  int64_t day = 0;             ///< days since 2000-01-01
  double second_of_day = 0.0;  ///< [0, 86400)

  /// The clock of everything that moves with time: wind, noise, animation.
  double seconds_since_2000() const { return static_cast<double>(day) * 86400.0 + second_of_day; }
  /// Julian date in UTC days.
  double julian_date() const { return 2451544.5 + static_cast<double>(day) + second_of_day / 86400.0; }
  /// Calendar year with fraction, 2000.0 at 2000-01-01; Gregorian mean years.
  double decimal_year() const { return 2000.0 + (static_cast<double>(day) + second_of_day / 86400.0) / 365.2425; }
  UtcInstant plus_seconds(double seconds) const;
  bool operator==(const UtcInstant&) const = default;
};

/// Reads ISO 8601: `2026-06-20`, `2026-06-20T23:30Z`, `2026-06-20T23:30:00.125Z`, `2026-06-21T08:30:00+09:00`. Without
/// a zone the time is UTC; without a time it is midnight. 24:00:00 is the next midnight and second 60 (23:59:60 UTC)
/// the first of the next minute. Throws Error(input) in one line for anything else and outside the years 1900..2100
/// UTC.
UtcInstant parse_utc(std::string_view text);

/// `2026-06-20T23:30:00Z`, with `decimals` (0..9) digits of the second, rounded.
std::string format_utc(const UtcInstant& instant, int decimals = 0);

/// Calendar date of a day count, proleptic Gregorian.
struct CalendarDate {
  int year = 2000, month = 1, day = 1;
};
CalendarDate calendar_from_day(int64_t days_since_2000);
int64_t day_from_calendar(const CalendarDate& date);

}  // namespace nepho
