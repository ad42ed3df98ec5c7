#include "base/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace nepho {

namespace {
spdlog::logger& logger() {
  static const std::shared_ptr<spdlog::logger> instance = [] {
    auto made = std::make_shared<spdlog::logger>("nepho", std::make_shared<spdlog::sinks::stderr_sink_mt>());
    made->set_pattern("nepho: %v");
    return made;
  }();
  return *instance;
}
}  // namespace

void set_log_level(LogLevel lowest) {
  constexpr spdlog::level::level_enum levels[] = {spdlog::level::debug, spdlog::level::info, spdlog::level::warn,
                                                  spdlog::level::err};
  logger().set_level(levels[static_cast<int>(lowest)]);
}

void log_line(LogLevel level, const std::string& line) {
  switch (level) {
    case LogLevel::debug: logger().debug("{}", line); break;
    case LogLevel::info: logger().info("{}", line); break;
    case LogLevel::warning: logger().warn("warning: {}", line); break;
    case LogLevel::error: logger().error("error: {}", line); break;
  }
}

}  // namespace nepho
