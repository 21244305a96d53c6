#pragma once

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>

#include "tests/eventually.hpp"

namespace terravox::test {

/// The log, kept for the test instead of going to standard error.
class Said {
public:
    Said() : m_before(spdlog::default_logger()), m_sink(std::make_shared<Sink>()) {
        spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", m_sink));
    }
    ~Said() { spdlog::set_default_logger(m_before); }
    [[nodiscard]] std::string all() const { return m_sink->text(); }
    [[nodiscard]] std::size_t warnings() const { return m_sink->warnings(); }
    /// Waits for a line that contains this.
    [[nodiscard]] bool hears(const std::string& part) const {
        return eventually([&] { return all().find(part) != std::string::npos; });
    }

private:
    class Sink final : public spdlog::sinks::base_sink<std::mutex> {
    public:
        std::string text() {
            const std::lock_guard lock(mutex_);
            return m_text;
        }
        std::size_t warnings() {
            const std::lock_guard lock(mutex_);
            return m_warnings;
        }

    private:
        void sink_it_(const spdlog::details::log_msg& message) override {
            m_text.append(message.payload.data(), message.payload.size()).append("\n");
            m_warnings += message.level == spdlog::level::warn ? 1 : 0;
        }
        void flush_() override {}
        std::string m_text;
        std::size_t m_warnings = 0;
    };
    std::shared_ptr<spdlog::logger> m_before;
    std::shared_ptr<Sink> m_sink;
};

}  // namespace terravox::test
