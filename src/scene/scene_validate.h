#pragma once
#include <functional>
#include <string>
#include <vector>

#include "base/error.h"
#include "scene/scene.h"

namespace nepho {

class FieldVisitor;

/// What a parameter is called in messages, from its path: "scene.json: clouds.coverage" or "--coverage".
using NameParameter = std::function<std::string(const std::string& path)>;

/// Throws an Error of `kind` unless every parameter is within its range and they fit together. One line:
/// "clouds.coverage: 1.5 is out of range; allowed: 0..1".
void validate(const Scene& scene, ErrorKind kind, const NameParameter& name = {});

/// The same for the members of one group, such as an entry of a stack; rules between members are not looked at.
void validate_members(const std::function<void(FieldVisitor&)>& visit, ErrorKind kind, const NameParameter& name);

/// "'hihg' is not one of low, medium, high, ultra; did you mean 'high'?"
std::string no_choice(const std::string& value, const std::vector<std::string>& choices);

/// The paths of all parameters, those of optional groups included: "camera.fov_deg", "clouds.layers[0].base_m".
std::vector<std::string> parameter_paths();

}  // namespace nepho
