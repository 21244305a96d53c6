#pragma once

#include <chrono>

namespace terravox::preview {

[[nodiscard]] inline double seconds(std::chrono::steady_clock::duration duration) noexcept {
    return std::chrono::duration<double>(duration).count();
}

[[nodiscard]] inline std::chrono::steady_clock::duration duration_of(double seconds) noexcept {
    return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
        std::chrono::duration<double>(seconds));
}

}  // namespace terravox::preview
