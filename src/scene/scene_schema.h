#pragma once
#include <string>

namespace nepho {

/// docs/scene.schema.json: the JSON Schema (2020-12) of scene files.
std::string scene_schema();

/// docs/parameters.md: every parameter with unit, range, default, meaning and its name in the literature.
std::string parameters_markdown();

}  // namespace nepho
