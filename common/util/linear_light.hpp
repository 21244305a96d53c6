#pragma once

#include <cstdint>

namespace terravox::util {

/// Linear light as integers, 65535 = the maximum of sRGB, so that sums and means are the same on
/// every machine.
inline constexpr std::uint32_t kBrightest = 65535;

/// Ref: IEC 61966-2-1 (sRGB).
[[nodiscard]] std::uint32_t to_linear(std::uint8_t srgb) noexcept;

/// The nearest sRGB value, so that to_srgb(to_linear(v)) == v. Values above kBrightest are clamped.
[[nodiscard]] std::uint8_t to_srgb(std::uint32_t linear) noexcept;

}  // namespace terravox::util
