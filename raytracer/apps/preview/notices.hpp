#pragma once

#include <spdlog/sinks/base_sink.h>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/apps/preview/final_render.hpp"
#include "raytracer/core/blocks/block_manager.hpp"

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

/// A line to show in the window.
struct Notice {
    std::string text;
    bool bad = false;
    bool logged = false;  ///< the line comes from the log, and need not be logged again
};

/// Collects events that nothing else in the window shows: warnings of the log, a world whose data
/// were replaced, the end of a final picture. Used by one thread.
class Notices {
public:
    /// @param log may be nullptr
    explicit Notices(std::shared_ptr<LogTail> log) : m_log(std::move(log)) {}

    /// @return the notices since the last call, oldest first; a changed world is reported once
    [[nodiscard]] std::vector<Notice> take(const blocks::BlockManager& blocks,
                                           const FinalRender::Status& final_render);

private:
    std::shared_ptr<LogTail> m_log;
    bool m_world_changed = false;  ///< and this was reported
    bool m_final_ran = false;      ///< a final picture was in progress at the last call
};

}  // namespace terravox::preview
