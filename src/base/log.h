#pragma once
#include <fmt/format.h>

#include <string>

namespace nepho {

/// Messages for people, on standard error: `nepho: warning: ...`. Standard output belongs to results.
enum class LogLevel { debug, info, warning, error };

void set_log_level(LogLevel lowest);  ///< default: info
void log_line(LogLevel level, const std::string& line);

template <typename... Args>
void log_info(fmt::format_string<Args...> format, Args&&... args) {
  log_line(LogLevel::info, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
void log_warning(fmt::format_string<Args...> format, Args&&... args) {
  log_line(LogLevel::warning, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
void log_debug(fmt::format_string<Args...> format, Args&&... args) {
  log_line(LogLevel::debug, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace nepho
