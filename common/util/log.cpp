#include "common/util/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>

#include <array>

#include "common/util/error.hpp"

namespace terravox::util {

void set_up_log(const std::string& level) {
    static constexpr std::array kLevels = {"trace", "debug", "info", "warn", "error", "off"};
    bool known = false;
    for (const char* name : kLevels) known = known || level == name;
    if (!known) throw UsageError("set the log level: '" + level + "'; allowed: trace, debug, info, warn, error, off");
    auto logger = std::make_shared<spdlog::logger>("terravox", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
    logger->set_pattern("[%^%l%$] %v");
    logger->set_level(spdlog::level::from_str(level == "warn" ? "warning" : level));
    spdlog::set_default_logger(std::move(logger));
}

}  // namespace terravox::util
