#pragma once
#include <string>

#include "scene/scene_fields.h"

namespace nepho {

/// The description of the parameter at a path such as "camera.fov_deg" (no list items).
Field parameter_field(const std::string& path);

/// Sets the number or text at a path from `text`, as a command line has it. `label` names it in messages. Throws
/// Error(usage): "--fov: 'wide' is not a number". Ranges of numbers are left to validate(), except where the value
/// would not fit the member.
void set_parameter(Scene& scene, const std::string& path, const std::string& text, const std::string& label);

/// A number that is all of `text`, such as "-33.8", "+5" or "1e3". Throws Error(usage) naming `label`.
double parse_number(const std::string& text, const std::string& label);

/// Shows a visitor the members of one group.
using MemberVisit = std::function<void(FieldVisitor&)>;

/// The same for a member of any group, such as an entry of a stack. `name` must be one of member_names().
void set_member(const MemberVisit& visit, const std::string& name, const std::string& text, const std::string& label);
std::vector<std::string> member_names(const MemberVisit& visit);

}  // namespace nepho
