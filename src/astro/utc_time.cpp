#include "astro/utc_time.h"

#include <array>
#include <chrono>
#include <cmath>

#include "base/error.h"

namespace nepho {

namespace {

using std::chrono::sys_days;
constexpr sys_days kDay0 = std::chrono::year{2000} / 1 / 1;

/// Walks over the text; every mistake names the text and the part.
class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text), rest_(text) {}
  bool done() const { return rest_.empty(); }
  bool next_is(char c) const { return !rest_.empty() && rest_.front() == c; }
  bool take(char c) {
    if (!next_is(c)) return false;
    rest_.remove_prefix(1);
    return true;
  }
  void require(char c) {
    if (!take(c)) throw wrong(fmt::format("'{}' is missing {}", c, where()));
  }
  int number(int digits, int lowest, int highest, const char* name) {
    int value = 0;
    for (int i = 0; i < digits; ++i) {
      if (rest_.empty() || rest_.front() < '0' || rest_.front() > '9')
        throw wrong(fmt::format("the {} needs {} digits {}", name, digits, where()));
      value = value * 10 + (rest_.front() - '0');
      rest_.remove_prefix(1);
    }
    if (value < lowest || value > highest)
      throw wrong(fmt::format("the {} is {}, not {}..{}", name, value, lowest, highest));
    return value;
  }
  /// Digits after the decimal mark.
  double fraction() {
    double value = 0.0, scale = 0.1;
    size_t digits = 0;
    for (; !rest_.empty() && rest_.front() >= '0' && rest_.front() <= '9'; ++digits, scale *= 0.1) {
      value += scale * (rest_.front() - '0');
      rest_.remove_prefix(1);
    }
    if (digits == 0) throw wrong("digits are missing after the decimal mark of the second");
    return value;
  }
  Error wrong(const std::string& why) const {
    return fail(ErrorKind::input, "time '{}': {}; write UTC as 2026-06-20T23:30:00Z", text_, why);
  }
  std::string where() const { return rest_.empty() ? std::string("at the end") : fmt::format("before '{}'", rest_); }

 private:
  std::string_view text_, rest_;
};

}  // namespace

CalendarDate calendar_from_day(int64_t days_since_2000) {
  const std::chrono::year_month_day date{kDay0 + std::chrono::days{days_since_2000}};
  return {int(date.year()), int(unsigned(date.month())), int(unsigned(date.day()))};
}

int64_t day_from_calendar(const CalendarDate& date) {
  const auto ymd = std::chrono::year{date.year} / date.month / date.day;
  return (sys_days{ymd} - kDay0).count();
}

UtcInstant UtcInstant::plus_seconds(double seconds) const {
  const double total = second_of_day + seconds;
  const double days = std::floor(total / 86400.0);
  UtcInstant moved{day + static_cast<int64_t>(days), total - days * 86400.0};
  if (moved.second_of_day >= 86400.0) moved = {moved.day + 1, 0.0};  // -1e-20 s rounds up to a whole day
  return moved;
}

UtcInstant parse_utc(std::string_view text) {
  Reader in(text);
  CalendarDate date;
  date.year = in.number(4, 0, 9999, "year");
  in.require('-');
  date.month = in.number(2, 1, 12, "month");
  in.require('-');
  date.day = in.number(2, 1, 31, "day");
  const auto ymd = std::chrono::year{date.year} / date.month / date.day;
  if (!ymd.ok()) throw in.wrong(fmt::format("{:04}-{:02} has no day {}", date.year, date.month, date.day));

  int hour = 0, minute = 0, second = 0, offset_minutes = 0;
  double fraction = 0.0;
  if (!in.done()) {
    if (!in.take('T') && !in.take('t') && !in.take(' ')) throw in.wrong(fmt::format("'T' is missing {}", in.where()));
    hour = in.number(2, 0, 24, "hour");
    in.require(':');
    minute = in.number(2, 0, 59, "minute");
    if (in.take(':')) {
      second = in.number(2, 0, 60, "second");
      if (in.take('.') || in.take(',')) fraction = in.fraction();
    }
    if (hour == 24 && (minute != 0 || second != 0 || fraction != 0.0)) throw in.wrong("the hour is 24 past midnight");
    if (in.next_is('+') || in.next_is('-')) {
      const int sign = in.take('-') ? -1 : 1;
      if (sign > 0) in.take('+');
      const int hours = in.number(2, 0, 23, "zone's hour");
      in.take(':');
      const int minutes = in.done() ? 0 : in.number(2, 0, 59, "zone's minute");
      offset_minutes = sign * (60 * hours + minutes);
    } else if (!in.take('Z')) {
      in.take('z');
    }
    if (!in.done()) throw in.wrong(fmt::format("something follows: {}", in.where().substr(7)));
  }
  const int utc_minutes = 60 * hour + minute - offset_minutes;
  if (second == 60 && (utc_minutes % 1440 + 1440) % 1440 != 1439) throw in.wrong("second 60 exists at 23:59 UTC only");
  const UtcInstant midnight{day_from_calendar(date), 0.0};
  const UtcInstant instant = midnight.plus_seconds(60.0 * utc_minutes + second + fraction);
  const int year = calendar_from_day(instant.day).year;
  if (year < 1900 || year > 2100) throw in.wrong(fmt::format("the year {} is outside 1900..2100", year));
  return instant;
}

std::string format_utc(const UtcInstant& instant, int decimals) {
  NEPHO_ASSERT(decimals >= 0 && decimals <= 9);
  int64_t units = 1;
  for (int i = 0; i < decimals; ++i) units *= 10;
  int64_t ticks = std::llround(instant.second_of_day * static_cast<double>(units));
  int64_t day = instant.day;
  if (ticks >= 86400 * units) {
    ticks -= 86400 * units;
    ++day;
  }
  const CalendarDate date = calendar_from_day(day);
  const int64_t seconds = ticks / units;
  std::string text = fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}", date.year, date.month, date.day, seconds / 3600,
                                 seconds / 60 % 60, seconds % 60);
  if (decimals > 0) text += fmt::format(".{:0{}}", ticks % units, decimals);
  return text + "Z";
}

}  // namespace nepho
