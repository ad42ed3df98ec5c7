#pragma once
#include <string>
#include <vector>

namespace nepho {

/// Views of the renderer's insides in false colours, for RenderRequest::debug; docs/clouds.md has their legends.
inline const std::vector<std::string>& known_debug_views() {
  static const std::vector<std::string> views{"weather", "density", "layers", "samples", "steps"};
  return views;
}

}  // namespace nepho
