#pragma once

#include <chrono>
#include <cstddef>

#include "raytracer/core/tiles/trace_counts.hpp"

namespace terravox::trace {

/// Attributes a thread's time to stages.
class StageClock {
public:
    void restart() noexcept { m_since = Clock::now(); }
    /// Adds the time since the last call, or since restart(), to this stage.
    void lap(tiles::TraceStage stage, tiles::TraceCounts& counts) noexcept {
        const Clock::time_point now = Clock::now();
        counts.seconds[static_cast<std::size_t>(stage)] +=
            std::chrono::duration<double>(now - m_since).count();
        m_since = now;
    }

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point m_since;
};

}  // namespace terravox::trace
