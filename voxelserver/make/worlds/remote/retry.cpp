#include "voxelserver/make/worlds/remote/retry.hpp"

#include <algorithm>

namespace terravox::remote {
namespace {

constexpr Retry::Milliseconds kFirstWait{100};
constexpr Retry::Milliseconds kLongestOwnWait{10'000};  // where the server requests none
constexpr int kGrowth = 3;

int max_tries(FailureKind kind) noexcept {
    switch (kind) {
        case FailureKind::kLost: return 5;
        case FailureKind::kFailed: return 3;
        case FailureKind::kDamaged: return 4;
        case FailureKind::kBusy: break;
    }
    return 1 << 30;  // the timeout ends it
}

Retry::Milliseconds own_wait(int tries) noexcept {
    Retry::Milliseconds wait = kFirstWait;
    for (int i = 1; i < tries && wait < kLongestOwnWait; ++i)
        wait *= kGrowth;
    return std::min(wait, kLongestOwnWait);
}

}  // namespace

Retry::Milliseconds Retry::time_left(Clock::time_point now) const noexcept {
    return std::max(Milliseconds{1}, std::chrono::duration_cast<Milliseconds>(m_end - now));
}

std::optional<Retry::Milliseconds> Retry::wait_after(
    FailureKind kind, Clock::time_point now, std::optional<std::chrono::seconds> retry_after,
    double chance) noexcept {
    ++m_tries;
    if (m_tries >= max_tries(kind) || (!m_is_reachable && kind != FailureKind::kBusy))
        return std::nullopt;
    const auto spread = [&](Milliseconds wait, double least, double most) {
        return Milliseconds(static_cast<Milliseconds::rep>(static_cast<double>(wait.count()) *
                                                           (least + (most - least) * chance)));
    };
    Milliseconds wait = spread(own_wait(m_tries), 0.5, 1.5);
    if (retry_after) {
        // Never earlier than requested. Clamped as seconds: the number is untrusted.
        constexpr auto kLongest = std::chrono::duration_cast<std::chrono::seconds>(kLongestWait);
        wait = std::max(
            wait, spread(std::clamp(*retry_after, std::chrono::seconds{0}, kLongest), 1, 1.25));
    }
    if (now + wait >= m_end)
        return std::nullopt;
    return wait;
}

}  // namespace terravox::remote
