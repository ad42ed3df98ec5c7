#pragma once
#include <string>

namespace nepho {

/// A time as parse_utc() of astro takes it (ISO 8601, 1900..2100, with or without a zone), as canonical UTC:
/// "2026-06-20T23:30:00Z", with as many decimals of the second, up to nine, as it has.
/// Throws Error(input) with one line that names the text and what is wrong with it.
std::string canonical_utc(const std::string& text);

}  // namespace nepho
