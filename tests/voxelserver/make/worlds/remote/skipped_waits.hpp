#pragma once

#include <atomic>
#include <chrono>

#include "voxelserver/make/worlds/remote/retry.hpp"

namespace terravox::test {

/// A clock that moves on by each wait instead of sitting it out. What a server lets pass counts as
/// well, so that a timeout ends with a silent server, too.
class SkippedWaits final : public remote::RetryClock {
public:
    [[nodiscard]] Steady::time_point now() const noexcept override {
        return Steady::now() + std::chrono::milliseconds(m_skipped_ms.load());
    }
    [[nodiscard]] std::chrono::milliseconds begin_wait(
        std::chrono::milliseconds time) noexcept override {
        m_skipped_ms += time.count();
        return std::chrono::milliseconds{0};
    }
    /// The sum of all waits so far.
    [[nodiscard]] std::chrono::milliseconds skipped() const noexcept {
        return std::chrono::milliseconds(m_skipped_ms.load());
    }

private:
    std::atomic<std::chrono::milliseconds::rep> m_skipped_ms{0};
};

}  // namespace terravox::test
