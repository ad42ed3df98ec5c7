#pragma once
#include "nepho/options.h"
#include "nepho/program.h"

namespace nepho {

/// `nepho render`: a picture of a scene.
class RenderCommand {
 public:
  void add_to(CLI::App& command, const Program& program);
  /// Checks everything that can be checked without a device, then renders. Throws Error.
  void run(const Program& program) const;

 private:
  RenderOutputs outputs(const Program& program) const;
  void check_reference(const Scene& scene, const RenderOutputs& wanted) const;

  SceneOptions scene_;
  std::vector<std::string> images_;
  std::string aov_, timings_, save_scene_, resume_, device_, debug_;
  bool validation_ = false, strict_ = false, incomplete_ok_ = false;
};

}  // namespace nepho
