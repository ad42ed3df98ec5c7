#pragma once
#include <string>
#include <vector>

#include "nepho/program.h"

namespace CLI {
class App;
}

namespace nepho {

/// `nepho bench`: times of scenes, pass by pass (docs/performance.md).
class BenchCommand {
 public:
  void add_to(CLI::App& command);
  /// Checks all options, then measures. Throws Error.
  void run(const Program& program) const;

 private:
  BenchRequest request() const;

  std::vector<std::string> scenes_, sizes_, qualities_, upscales_;
  uint32_t frames_ = 16, warm_up_ = 16;
  double speed_mps_ = 0.0, turn_deg_s_ = 0.0;
  bool moves_ = false;
  std::string json_, pictures_, device_;
  bool validation_ = false;
};

}  // namespace nepho
