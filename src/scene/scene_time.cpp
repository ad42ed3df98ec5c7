#include "scene/scene_time.h"

#include <charconv>
#include <chrono>

#include "base/error.h"

namespace nepho {

namespace {

/// Takes a time apart from left to right.
class Scanner {
 public:
  explicit Scanner(const std::string& text) : text_(text) {}
  bool at_end() const { return at_ == text_.size(); }
  bool take(char c) {
    if (at_end() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void need(char c) {
    if (!take(c)) throw malformed();
  }
  /// Exactly `count` digits.
  int digits(size_t count) {
    int value = 0;
    for (size_t i = 0; i < count; ++i, ++at_) {
      if (at_end() || text_[at_] < '0' || text_[at_] > '9') throw malformed();
      value = value * 10 + (text_[at_] - '0');
    }
    return value;
  }
  /// All digits that follow: 1 to 9 of them, without trailing zeros.
  std::string fraction() {
    const size_t begin = at_;
    while (!at_end() && text_[at_] >= '0' && text_[at_] <= '9') ++at_;
    std::string found = text_.substr(begin, at_ - begin);
    if (found.empty() || found.size() > 9) throw malformed();
    while (!found.empty() && found.back() == '0') found.pop_back();
    return found;
  }
  Error malformed() const {
    return fail(ErrorKind::input, "'{}' is not an ISO 8601 time such as 2026-06-20T23:30:00Z", text_);
  }
  Error impossible(const char* what) const { return fail(ErrorKind::input, "'{}' has no such {}", text_, what); }

 private:
  const std::string& text_;
  size_t at_ = 0;
};

}  // namespace

std::string canonical_utc(const std::string& text) {
  using namespace std::chrono;
  Scanner in(text);
  const int year_number = in.digits(4);
  in.need('-');
  const int month_number = in.digits(2);
  in.need('-');
  const int day_number = in.digits(2);
  int h = 0, min = 0, s = 0, zone_minutes = 0;
  std::string fraction;
  if (in.take('T') || in.take('t') || in.take(' ')) {
    h = in.digits(2);
    in.need(':');
    min = in.digits(2);
    if (in.take(':')) {
      s = in.digits(2);
      if (in.take('.') || in.take(',')) fraction = in.fraction();
    }
    if (!in.take('Z') && !in.take('z') && !in.at_end()) {
      const int sign = in.take('-') ? -1 : (in.need('+'), 1);
      const int zone_h = in.digits(2);
      in.take(':');
      const int zone_min = in.at_end() ? 0 : in.digits(2);
      if (zone_h > 14 || zone_min > 59) throw in.impossible("zone");
      zone_minutes = sign * (zone_h * 60 + zone_min);
    }
  }
  if (!in.at_end()) throw in.malformed();

  const year_month_day date =
      year(year_number) / month(static_cast<unsigned>(month_number)) / day(static_cast<unsigned>(day_number));
  if (!date.ok()) throw in.impossible("day in the calendar");
  if (h > 23 || min > 59 || s > 60) throw in.impossible("time of day");
  const auto minute_utc = sys_days(date) + hours(h) + minutes(min - zone_minutes);
  const sys_days day_utc = floor<days>(minute_utc);
  const year_month_day ymd(day_utc);
  const hh_mm_ss of_day(minute_utc - day_utc);
  if (s == 60 && (of_day.hours().count() != 23 || of_day.minutes().count() != 59))
    throw in.impossible("time of day: second 60 occurs at 23:59 UTC only");
  if (int(ymd.year()) < 1900 || int(ymd.year()) > 2100)
    throw fail(ErrorKind::input, "'{}' is outside 1900..2100", text);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}{}{}Z", int(ymd.year()), unsigned(ymd.month()),
                     unsigned(ymd.day()), of_day.hours().count(), of_day.minutes().count(), s,
                     fraction.empty() ? "" : ".", fraction);
}

}  // namespace nepho
