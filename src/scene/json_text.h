#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "scene/source_params.h"

// Private to scene: JSON text with messages that name the place. Include in .cpp files only.
namespace nepho {

using Json = nlohmann::ordered_json;

/// Parses a JSON text. Throws Error(input): "scene.json: line 3, column 7: not JSON: ..." or a repeated key.
Json parse_json(const std::string& text, const std::string& source);

/// What was found, for messages: "a string (\"abc\")", "a list".
std::string describe_json(const Json& value);

/// "auto", "none" or [low, high].
Json json_of_stretch(const Stretch& stretch);

}  // namespace nepho
