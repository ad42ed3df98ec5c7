#pragma once
#include <string>

namespace nepho {

/// An ISO 8601 time as canonical UTC, "2026-06-20T23:30:00Z" (with a fraction of up to nine digits where there is one).
/// Takes a date alone (midnight), hours and minutes, seconds, a fraction, and a zone: Z, +HH:MM, or none for UTC.
/// 1900-01-01 to 2100-12-31; second 60 only at 23:59 UTC, where leap seconds are.
/// Throws Error(input) with one line that names the text and what is wrong with it.
std::string canonical_utc(const std::string& text);

}  // namespace nepho
