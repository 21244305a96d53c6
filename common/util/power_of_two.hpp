#pragma once

#include <bit>
#include <cstdint>

namespace terravox {

/// 2^n, exactly, without a call of the library. @param n -1022 to 1023
[[nodiscard]] constexpr double power_of_two(int n) noexcept { return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + n) << 52); }

}  // namespace terravox
