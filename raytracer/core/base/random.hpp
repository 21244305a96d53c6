#pragma once

#include <cstdint>

namespace terravox::core {

/// Random numbers as a pure function of their arguments: the same pixel, sample and use always give
/// the same number, whatever the thread or the order of the calls. Ref: Steele, Lea, Flood, "Fast
/// splittable pseudorandom number generators", OOPSLA 2014 (the finalizer).
[[nodiscard]] constexpr std::uint64_t hash64(std::uint64_t v) noexcept {
    v += 0x9e3779b97f4a7c15;
    v = (v ^ v >> 30) * 0xbf58476d1ce4e5b9;
    v = (v ^ v >> 27) * 0x94d049bb133111eb;
    return v ^ v >> 31;
}
[[nodiscard]] constexpr std::uint64_t hash64(std::uint64_t a, std::uint64_t b) noexcept {
    return hash64(a ^ hash64(b));
}

/// Maps a hash to a uniform number in [0, 1).
[[nodiscard]] constexpr double unit_from(std::uint64_t hash) noexcept {
    return static_cast<double>(hash >> 11) * 0x1.0p-53;
}

}  // namespace terravox::core
