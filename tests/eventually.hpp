#pragma once

#include <chrono>
#include <thread>

namespace terravox::test {

/// What ends a test that hangs. No test measures time: a loaded machine may need minutes for what
/// takes a moment elsewhere.
inline constexpr std::chrono::minutes kHangs{5};

/// Waits until a condition holds. @return false: it did not for so long that it never will
template <class Condition>
[[nodiscard]] bool eventually(const Condition& condition) {
    const auto end = std::chrono::steady_clock::now() + kHangs;
    while (!condition()) {
        if (std::chrono::steady_clock::now() > end)
            return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}

}  // namespace terravox::test
