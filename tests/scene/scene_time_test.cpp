#include "scene/scene_time.h"

#include <doctest/doctest.h>

#include "base/error.h"

using namespace nepho;

TEST_CASE("a UTC time is canonical already") {
  CHECK(canonical_utc("2026-06-20T23:30:00Z") == "2026-06-20T23:30:00Z");
  CHECK(canonical_utc("1900-01-01T00:00:00Z") == "1900-01-01T00:00:00Z");
  CHECK(canonical_utc("2100-12-31T23:59:59.999Z") == "2100-12-31T23:59:59.999Z");
  CHECK(canonical_utc("1900-03-01T12:00:00.000000001Z") == "1900-03-01T12:00:00.000000001Z");
}

TEST_CASE("seconds, minutes, time of day and zone may be left out") {
  CHECK(canonical_utc("2026-06-20") == "2026-06-20T00:00:00Z");
  CHECK(canonical_utc("2026-06-20T23:30") == "2026-06-20T23:30:00Z");
  CHECK(canonical_utc("2026-06-20 23:30:05") == "2026-06-20T23:30:05Z");
}

TEST_CASE("a zone is converted to UTC across midnight, months, leap days and years") {
  CHECK(canonical_utc("2026-06-21T08:30:00+09:00") == "2026-06-20T23:30:00Z");
  CHECK(canonical_utc("2024-02-28T20:00:00-05:00") == "2024-02-29T01:00:00Z");
  CHECK(canonical_utc("2026-01-01T00:00:00+0530") == "2025-12-31T18:30:00Z");
  CHECK(canonical_utc("2026-12-31T23:00:00.50-01") == "2027-01-01T00:00:00.5Z");
}

TEST_CASE("a malformed, impossible or too distant time is an input error that quotes it") {
  for (const char* text :
       {"", "now", "2026", "2026-6-20", "2026-02-29", "2026-13-01", "2026-06-20T25:00:00Z", "2026-06-20T23:60Z",
        "2026-06-20T23:30:00Zx", "2026-06-20T23:30:00+99:00", "2026-06-20T", "2026-06-20T23:30:00.Z", "-026-06-20",
        "1899-12-31", "2101-01-01", "2101-01-01T00:00:00Z", "1900-01-01T00:00:00+01:00"}) {
    CAPTURE(text);
    try {
      const std::string accepted = canonical_utc(text);
      FAIL_CHECK(accepted);
    } catch (const Error& e) {
      CHECK(e.kind() == ErrorKind::input);
      CHECK(std::string(e.what()).find("'" + std::string(text) + "'") != std::string::npos);
    }
  }
}
