#pragma once

#include <bit>
#include <cstdint>

namespace terravox::test {

/// Not what == says: NaN is itself, and 0 is not -0.
inline bool same_bits(float a, float b) noexcept {
    return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

}  // namespace terravox::test
