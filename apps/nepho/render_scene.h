#pragma once
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace nepho {

struct RasterAccess;

/// What `nepho render` writes, and with which device. All names are checked before the device is opened.
struct RenderOutputs {
  std::vector<std::filesystem::path> images;  ///< .exr or .png
  std::set<std::string> layers;               ///< of EXR files, names of known_layers(); empty: all
  std::string debug;                          ///< a name of known_debug_views() instead of the picture; empty: none
  std::filesystem::path resume;               ///< a picture of quality reference to go on with; empty: none
  std::filesystem::path timings;              ///< JSON; empty: none
  std::string device;                         ///< as gpu::DeviceOptions::device
  bool validation = false;                    ///< Vulkan validation layer
  bool strict = false;         ///< a raster of the ground that is bad, fails, or is not in view is an Error(input)
  bool incomplete_ok = false;  ///< draw the ground as far as it is loaded
};

/// Draws a scene and writes its outputs. Throws Error.
void render_scene(const Scene& scene, const RenderOutputs& outputs, const RasterAccess& rasters);

}  // namespace nepho
