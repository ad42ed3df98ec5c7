#pragma once
#include <doctest/doctest.h>

#include <string>

#include "base/error.h"
#include "scene/scene_json.h"

namespace nepho::test {

/// The message, one line, of the input error that reading `text` as s.json ends with.
inline std::string reading_fails(const std::string& text) {
  try {
    scene_from_json(text, "s.json");
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::input);
    CHECK(std::string(e.what()).find('\n') == std::string::npos);
    return e.what();
  }
  return "(no error)";
}

}  // namespace nepho::test
