#pragma once

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <sstream>
#include <string>

#include "common/util/log.hpp"

namespace terravox::test {

/// Collects what the program warns of while this lives, instead of printing it. One at a time.
class Warnings {
public:
    /// @param level from which on messages are collected
    explicit Warnings(spdlog::level::level_enum level = spdlog::level::warn)
        : m_before(spdlog::default_logger()) {
        util::say_shared_warnings();  // what files of other tests have shared
        auto logger = std::make_shared<spdlog::logger>(
            "warnings", std::make_shared<spdlog::sinks::ostream_sink_mt>(m_text));
        logger->set_level(level);
        logger->set_pattern("%v");
        spdlog::set_default_logger(std::move(logger));
    }
    ~Warnings() { spdlog::set_default_logger(m_before); }
    Warnings(const Warnings&) = delete;
    Warnings& operator=(const Warnings&) = delete;

    [[nodiscard]] std::string text() const { return m_text.str(); }
    /// How many warnings hold `part`.
    [[nodiscard]] int count(const std::string& part) const {
        std::istringstream lines(m_text.str());
        int found = 0;
        for (std::string line; std::getline(lines, line);)
            found += line.find(part) != std::string::npos ? 1 : 0;
        return found;
    }

private:
    std::ostringstream m_text;
    std::shared_ptr<spdlog::logger> m_before;
};

}  // namespace terravox::test
