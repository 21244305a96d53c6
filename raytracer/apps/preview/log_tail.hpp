#pragma once

#include <spdlog/sinks/base_sink.h>

#include <mutex>
#include <string>
#include <utility>

namespace terravox::preview {

/// Keeps the newest warning or error of the log for display in the window: lost workers, boxes that
/// cannot be loaded. Thread-safe.
class LogTail final : public spdlog::sinks::base_sink<std::mutex> {
public:
    LogTail() { set_level(spdlog::level::warn); }
    /// @return the newest line since the last call; empty: none
    [[nodiscard]] std::string take() {
        const std::lock_guard lock(mutex_);
        return std::exchange(m_line, {});
    }

protected:
    void sink_it_(const spdlog::details::log_msg& message) override {
        m_line.assign(message.payload.data(), message.payload.size());
    }
    void flush_() override {}

private:
    std::string m_line;
};

}  // namespace terravox::preview
