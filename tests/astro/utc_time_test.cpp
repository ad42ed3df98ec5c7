#include "astro/utc_time.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "base/error.h"

using namespace nepho;

namespace {
std::string reason(const std::string& text) {
  try {
    parse_utc(text);
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::input);
    CHECK(std::string(e.what()).find('\n') == std::string::npos);
    return e.what();
  }
  return "";
}
}  // namespace

TEST_CASE("the clock counts seconds from 2000-01-01T00:00:00 UTC") {
  CHECK(parse_utc("2000-01-01T00:00:00Z").seconds_since_2000() == 0.0);
  CHECK(parse_utc("2000-01-02").seconds_since_2000() == 86400.0);
  CHECK(parse_utc("1999-12-31T23:59:59Z").seconds_since_2000() == -1.0);
  CHECK(parse_utc("2026-06-20T23:30:00Z").seconds_since_2000() == 9667.0 * 86400.0 + 84600.0);
}

TEST_CASE("Julian dates: J2000.0 is 2451545, the Unix epoch 2440587.5") {
  CHECK(parse_utc("2000-01-01T12:00:00Z").julian_date() == 2451545.0);
  CHECK(parse_utc("1970-01-01").julian_date() == 2440587.5);
  CHECK(parse_utc("1900-01-01").julian_date() == 2415020.5);
}

TEST_CASE("one moment in many spellings") {
  const UtcInstant t = parse_utc("2026-06-20T23:30:00Z");
  for (const char* text : {"2026-06-20T23:30Z", "2026-06-20T23:30:00", "2026-06-20 23:30:00Z", "2026-06-20t23:30:00z",
                           "2026-06-20T23:30:00.000Z", "2026-06-21T08:30:00+09:00", "2026-06-21T08:30+0900",
                           "2026-06-21T08:30:00+09", "2026-06-20T13:30:00-10:00", "2026-06-21T05:15:00+05:45"}) {
    CAPTURE(text);
    CHECK(parse_utc(text) == t);
  }
  CHECK(parse_utc("2026-06-20T24:00:00Z") == parse_utc("2026-06-21"));
  CHECK(parse_utc("2016-12-31T23:59:60Z") == parse_utc("2017-01-01"));
  CHECK(parse_utc("2017-01-01T08:59:60+09:00") == parse_utc("2017-01-01"));
}

TEST_CASE("fractions of a second are kept to a nanosecond") {
  CHECK(parse_utc("2099-12-31T23:59:59.123456789Z").second_of_day == doctest::Approx(86399.123456789).epsilon(1e-15));
  CHECK(parse_utc("2026-06-20T00:00:00,5Z").second_of_day == 0.5);
}

TEST_CASE("mistakes are named in one line") {
  CHECK(reason("2026-02-29").find("no day 29") != std::string::npos);
  CHECK(reason("2026-13-01").find("month is 13") != std::string::npos);
  CHECK(reason("2026-06-20T25:00").find("hour is 25") != std::string::npos);
  CHECK(reason("2026-06-20T24:00:01Z").find("24") != std::string::npos);
  CHECK(reason("2026-06-20T12:00:60Z").find("second 60") != std::string::npos);
  CHECK(reason("2026-06-20T12").find("':' is missing") != std::string::npos);
  CHECK(reason("2026-06-20T12:00:00.Z").find("digits are missing") != std::string::npos);
  CHECK(reason("2026-06-20T12:00:00Zulu").find("'ulu'") != std::string::npos);
  CHECK(reason("20260620").find("'-' is missing") != std::string::npos);
  CHECK(reason("").find("year needs 4 digits") != std::string::npos);
  CHECK(reason("now").find("'now'") != std::string::npos);
  CHECK(reason("2026-06-20Z").find("'T' is missing") != std::string::npos);
}

TEST_CASE("valid from 1900-01-01 to the end of 2100 UTC") {
  CHECK_NOTHROW(parse_utc("1900-01-01T00:00:00Z"));
  CHECK_NOTHROW(parse_utc("2100-12-31T23:59:59.999Z"));
  CHECK(reason("1899-12-31T23:59:59Z").find("1899 is outside 1900..2100") != std::string::npos);
  CHECK(reason("2101-01-01").find("2101") != std::string::npos);
  CHECK(reason("1900-01-01T05:00:00+09:00").find("1899") != std::string::npos);
  CHECK(reason("0000-01-01").find("outside") != std::string::npos);
}

TEST_CASE("formatting gives back what was read, and rounding carries into the next day") {
  for (const char* text :
       {"1900-01-01T00:00:00Z", "1972-02-29T12:34:56Z", "2026-06-20T23:30:00Z", "2100-12-31T23:59:59Z"})
    CHECK(format_utc(parse_utc(text)) == text);
  CHECK(format_utc(parse_utc("2036-05-07T17:35:04.600Z"), 3) == "2036-05-07T17:35:04.600Z");
  CHECK(format_utc(parse_utc("2026-12-31T23:59:59.9996Z"), 3) == "2027-01-01T00:00:00.000Z");
}

TEST_CASE("adding seconds carries over days both ways") {
  const UtcInstant t = parse_utc("2026-12-31T23:59:50Z");
  CHECK(format_utc(t.plus_seconds(20.0)) == "2027-01-01T00:00:10Z");
  CHECK(format_utc(t.plus_seconds(-86400.0 * 365.0)) == "2025-12-31T23:59:50Z");
  const UtcInstant tiny = UtcInstant{}.plus_seconds(-1e-20);
  CHECK(tiny.second_of_day < 86400.0);
}
