#pragma once

#include <chrono>
#include <cstdint>

#include "voxelserver/serve/boxes/preparer.hpp"

namespace terravox::serve {

/// Reports the progress of preparing: a bar on a terminal, else a log line now and then. Not
/// thread-safe.
class PrepareProgress {
public:
    /// @param bar whether standard error is a terminal and the log has the text format
    explicit PrepareProgress(bool bar) : m_bar(bar) {}
    void show(const boxes::Preparer::Progress& now);
    void end(const boxes::Preparer::Progress& now);  ///< the final report

private:
    using Clock = std::chrono::steady_clock;
    bool m_bar;
    std::uint64_t m_reported_percent = 0;
    Clock::time_point m_start = Clock::now();
};

}  // namespace terravox::serve
