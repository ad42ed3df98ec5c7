#pragma once
#include <cstdlib>
#include <string>

namespace nepho::test {

/// A file of tests/oracles, or of the folder $NEPHO_TEST_ORACLES where the sources are not (tests/tools/bundle.sh).
inline std::string oracle_path(const std::string& file) {
  const char* folder = std::getenv("NEPHO_TEST_ORACLES");
  return (folder ? std::string(folder) : std::string(NEPHO_SOURCE_DIR) + "/tests/oracles") + "/" + file;
}

}  // namespace nepho::test
