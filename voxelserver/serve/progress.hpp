#pragma once

#include <chrono>
#include <cstdint>

#include "voxelserver/boxes/preparer.hpp"

namespace terravox::serve {

/// Tells how far preparing is: a bar on a terminal, else a log line now and then. Not thread-safe.
class PrepareProgress {
public:
    explicit PrepareProgress(bool bar)
        : m_bar(bar) {}  ///< @param bar standard error is a terminal and the log is for people
    void show(const boxes::Preparer::Progress& now);
    void end(const boxes::Preparer::Progress& now);  ///< the last word

private:
    using Clock = std::chrono::steady_clock;
    bool m_bar;
    std::uint64_t m_told_percent = 0;
    Clock::time_point m_start = Clock::now();
};

}  // namespace terravox::serve
