#pragma once

#include <cstdint>

namespace terravox::util {

/// A bijection that spreads every bit over the whole word: the same on every machine. What it gave
/// once is in pictures and worlds, so it never changes. Ref: the finaliser of SplitMix64: Steele,
/// Lea & Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014.
[[nodiscard]] constexpr std::uint64_t mix(std::uint64_t v) noexcept {
    v += 0x9e3779b97f4a7c15;
    v = (v ^ v >> 30) * 0xbf58476d1ce4e5b9;
    v = (v ^ v >> 27) * 0x94d049bb133111eb;
    return v ^ v >> 31;
}

}  // namespace terravox::util
