#pragma once

#include <cstdint>

#include "common/util/mix.hpp"

namespace terravox::core {

/// Random numbers as a pure function of their arguments: the same pixel, sample and use always give
/// the same number, whatever the thread or the order of the calls.
[[nodiscard]] constexpr std::uint64_t hash64(std::uint64_t v) noexcept {
    return util::mix(v);
}
[[nodiscard]] constexpr std::uint64_t hash64(std::uint64_t a, std::uint64_t b) noexcept {
    return hash64(a ^ hash64(b));
}

/// Maps a hash to a uniform number in [0, 1).
[[nodiscard]] constexpr double unit_from(std::uint64_t hash) noexcept {
    return static_cast<double>(hash >> 11) * 0x1.0p-53;
}

}  // namespace terravox::core
