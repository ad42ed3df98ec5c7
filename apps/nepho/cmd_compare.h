#pragma once
#include <string>

#include "nepho/program.h"

namespace CLI {
class App;
}  // namespace CLI

namespace nepho {

/// `nepho compare`: how far a picture is from a reference.
class CompareCommand {
 public:
  /// Adds its options. `this` must outlive the parse.
  void add_to(CLI::App& command);
  /// Checks everything that can be checked without reading the pictures, then compares. Throws Error.
  void run(const Program& program) const;

 private:
  std::string a_, b_, mask_ = "none", exposure_ = "auto", tone_curve_, json_, heatmap_;
};

}  // namespace nepho
