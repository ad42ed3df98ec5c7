#include "base/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace nepho {

Progress::Progress(std::string label) : label_(std::move(label)), on_terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::update(double fraction, const std::string& note) {
  if (!on_terminal_) return;
  const auto now = std::chrono::steady_clock::now();
  if (drawn_ && now - last_draw_ < std::chrono::milliseconds(100)) return;
  last_draw_ = now;
  drawn_ = true;
  std::fprintf(stderr, "\r%s %3.0f %%%s%s\033[K", label_.c_str(), 100.0 * std::clamp(fraction, 0.0, 1.0),
               note.empty() ? "" : "  ", note.c_str());
  std::fflush(stderr);
}

}  // namespace nepho
