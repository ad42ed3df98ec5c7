#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "base/files.h"

using namespace nepho;
namespace fs = std::filesystem;

TEST_CASE("nearest_name finds a misspelt key and gives nothing for an unrelated word") {
  const std::vector<std::string> known{"coverage", "exposure", "terrain"};
  CHECK(nearest_name("covrage", known) == "coverage");
  CHECK(nearest_name("xq", known).empty());
}

TEST_CASE("write_whole_file leaves nothing behind when the writer throws") {
  const fs::path dir = fs::temp_directory_path() / "nepho_base_test";
  fs::remove_all(dir);
  fs::create_directories(dir);
  const fs::path out = dir / "a.txt";
  CHECK_THROWS(write_whole_file(out, [](const fs::path& t) {
    std::ofstream(t) << "half";
    throw Error(ErrorKind::failure, "stop");
  }));
  CHECK(fs::is_empty(dir));
  write_whole_file(out, [](const fs::path& t) { std::ofstream(t) << "whole"; });
  CHECK(read_text_file(out) == "whole");
  fs::remove_all(dir);
}

TEST_CASE("an output in a folder that does not exist is an error of kind failure that names it") {
  try {
    require_writable("/nonexistent-folder/x.png");
    FAIL("no error");
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::failure);
    CHECK(std::string(e.what()).find("/nonexistent-folder") != std::string::npos);
  }
}
