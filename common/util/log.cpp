#include "common/util/log.hpp"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <unordered_set>
#include <utility>
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

namespace {

/// What files have in common. Of a shared object that is loaded into a program there are two: its
/// own says what is left when it ends.
class SharedWarnings {
public:
    SharedWarnings() = default;
    SharedWarnings(const SharedWarnings&) = delete;
    SharedWarnings& operator=(const SharedWarnings&) = delete;
    ~SharedWarnings() { say(); }

    /// @return whether nobody has warned of this yet
    bool is_first(const std::string& file, const std::string& fact) {
        constexpr std::size_t kMaxFacts = 256;
        const std::lock_guard lock(m_mutex);
        if (m_others.size() >= kMaxFacts && !m_others.contains(fact))
            return true;
        Others& others = m_others[fact];
        if (others.files.insert(std::hash<std::string>{}(file)).second && others.files.size() == 2)
            others.name = file;
        return others.files.size() == 1 && !std::exchange(others.is_said, true);
    }

    void say() noexcept {
        const std::lock_guard lock(m_mutex);
        for (auto& [fact, others] : m_others) {
            const std::size_t count = others.files.size() - 1;
            if (count == 1)
                log_warn("{}: {}", others.name, fact);
            else if (count > 1)
                log_warn("{} other files, such as {}: {}", count, others.name, fact);
        }
        m_others.clear();
    }

private:
    struct Others {
        std::unordered_set<std::size_t> files;  ///< by their names; the first is one of them
        std::string name;                       ///< of the second
        bool is_said = false;
    };
    std::mutex m_mutex;
    std::map<std::string, Others> m_others;
};

SharedWarnings& shared_warnings() {
    static SharedWarnings out;
    return out;
}

}  // namespace

void warn_of_file(const std::string& file, const std::string& fact, const std::string& detail) {
    // The log is made before what is said at its end.
    if (is_logged(LogLevel::kWarning) && shared_warnings().is_first(file, fact))
        log_warn("{}: {}{}", file, fact, detail.empty() ? "" : " (" + detail + ")");
}

void say_shared_warnings() noexcept {
    shared_warnings().say();
}

}  // namespace terravox::util
