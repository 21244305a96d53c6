#include "common/util/log.hpp"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/text.hpp"

namespace terravox::util {
namespace {

class JsonLines final : public spdlog::formatter {
public:
    void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
        using namespace std::chrono;
        const auto ms = duration_cast<milliseconds>(message.time.time_since_epoch()).count();
        const std::time_t seconds = static_cast<std::time_t>(ms / 1000);
        std::tm utc{};
        gmtime_r(&seconds, &utc);
        std::array<char, 32> date{};
        const std::size_t length =
            std::strftime(date.data(), date.size(), "%Y-%m-%dT%H:%M:%S", &utc);
        std::array<char, 8> fraction{};
        std::snprintf(fraction.data(), fraction.size(), ".%03dZ", static_cast<int>(ms % 1000));
        const auto level = spdlog::level::to_string_view(message.level);
        const nlohmann::ordered_json line = {
            {"time", std::string(date.data(), length) + fraction.data()},
            {"level", std::string(level.data(), level.size())},
            {"message", std::string(message.payload.data(), message.payload.size())}};
        const std::string text =
            line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
        out.append(text.data(), text.data() + text.size());
    }
    [[nodiscard]] std::unique_ptr<spdlog::formatter> clone() const override {
        return std::make_unique<JsonLines>();
    }
};

/// Escapes the text of messages, which may contain untrusted parts, before another formatter makes
/// lines of them.
class Cleaning final : public spdlog::formatter {
public:
    explicit Cleaning(std::unique_ptr<spdlog::formatter> inner) : m_inner(std::move(inner)) {}
    void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
        const std::string text = printable({message.payload.data(), message.payload.size()});
        spdlog::details::log_msg clean = message;
        clean.payload = text;
        m_inner->format(clean, out);
        message.color_range_start = clean.color_range_start;
        message.color_range_end = clean.color_range_end;
    }
    [[nodiscard]] std::unique_ptr<spdlog::formatter> clone() const override {
        return std::make_unique<Cleaning>(m_inner->clone());
    }

private:
    std::unique_ptr<spdlog::formatter> m_inner;
};

std::unique_ptr<spdlog::formatter> log_formatter(LogFormat format) {
    if (format == LogFormat::kJson)
        return std::make_unique<Cleaning>(std::make_unique<JsonLines>());
    return std::make_unique<Cleaning>(std::make_unique<spdlog::pattern_formatter>("[%^%l%$] %v"));
}

spdlog::level::level_enum to_level(LogLevel level) noexcept {
    switch (level) {
        case LogLevel::kTrace: return spdlog::level::trace;
        case LogLevel::kDebug: return spdlog::level::debug;
        case LogLevel::kInfo: return spdlog::level::info;
        case LogLevel::kWarning: return spdlog::level::warn;
        case LogLevel::kError: return spdlog::level::err;
        case LogLevel::kCritical: break;
    }
    return spdlog::level::critical;
}

}  // namespace

void set_up_log(const std::string& level, LogFormat format) {
    const std::vector<std::string> levels = {"trace", "debug", "info", "warn", "error", "off"};
    if (std::find(levels.begin(), levels.end(), level) == levels.end())
        throw UsageError("set the log level: --log '{}'{}", level, allowed_words(level, levels));
    auto logger = std::make_shared<spdlog::logger>(
        "terravox", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
    logger->set_formatter(log_formatter(format));
    logger->set_level(spdlog::level::from_str(level == "warn" ? "warning" : level));
    spdlog::set_default_logger(std::move(logger));
}

bool is_logged(LogLevel level) {
    return spdlog::should_log(to_level(level));
}

void write_log(LogLevel level, fmt::string_view format, fmt::format_args arguments) noexcept {
    try {
        if (is_logged(level))
            spdlog::default_logger_raw()->log(to_level(level), fmt::vformat(format, arguments));
    } catch (...) {
        // Without memory for the text, or with arguments that do not fit it.
        std::fputs("[error] a message of the log could not be written\n", stderr);
    }
}

}  // namespace terravox::util
