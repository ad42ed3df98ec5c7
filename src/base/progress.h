#pragma once
#include <chrono>
#include <string>

namespace nepho {

/// A progress line on standard error, shown on a terminal only and wiped when done.
class Progress {
 public:
  explicit Progress(std::string label);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// `fraction` in 0..1; `note` stands behind it. Redraws at most ten times a second.
  void update(double fraction, const std::string& note = {});

 private:
  std::string label_;
  bool on_terminal_ = false;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_draw_{};
};

}  // namespace nepho
