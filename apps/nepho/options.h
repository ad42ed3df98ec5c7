#pragma once
#include <map>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace nepho {

/// The options that describe a scene, the same for every command. Their help, units and ranges come from the table of
/// parameters (scene_fields.h).
class SceneOptions {
 public:
  /// Adds them to a command. `this` must outlive the parse.
  void add_to(CLI::App& command);
  /// The scene file, or the named place, or the place `fuji`, with the other options over it.
  /// Throws Error(usage) naming the option, Error(input) for the scene file.
  Scene scene() const;

 private:
  void add_text(CLI::App& command, const std::string& flag, const std::string& placeholder, const std::string& help);
  bool given(const std::string& flag) const { return text_.count(flag) != 0 && count(flag) > 0; }
  size_t count(const std::string& flag) const;
  void place_camera(Scene& scene) const;
  void set_air(AtmosphereParams& air) const;
  void set_clouds(CloudParams& clouds) const;

  std::string file_;
  std::map<std::string, std::string> text_;  ///< flag -> its argument
  std::map<std::string, CLI::Option*> options_;
  std::vector<std::string> terrain_, imagery_;
};

inline constexpr const char* kDeviceHelp = "Vulkan device: its number or a part of its name, see nepho info";

/// Adds an option of one argument that may be repeated, and takes one argument each time.
CLI::Option* add_repeated(CLI::App& command, const std::string& flags, std::vector<std::string>& values,
                          const std::string& placeholder, const std::string& help);

/// Sets width and height from "640x360". Throws Error(usage) naming --size.
void set_size(RenderParams& render, const std::string& text);

/// Throws Error(input) unless every file that the scene names and that is a path of this machine exists.
void require_inputs(const Scene& scene);

}  // namespace nepho
