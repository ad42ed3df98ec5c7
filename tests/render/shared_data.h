#pragma once
#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace nepho {

/// A file of the shared data ($NEPHO_SHARED, default ../shared beside the source tree); empty, with a message, when
/// absent.
inline std::string shared_data(const std::string& relative) {
  const char* env = std::getenv("NEPHO_SHARED");
  const std::filesystem::path root =
      env ? std::filesystem::path(env) : std::filesystem::path(NEPHO_SOURCE_DIR) / ".." / "shared";
  const std::filesystem::path path = root / "data" / relative;
  if (std::filesystem::exists(path)) return path.string();
  MESSAGE("not there, part of the test is left out (set NEPHO_SHARED): " << path.string());
  return {};
}

}  // namespace nepho
