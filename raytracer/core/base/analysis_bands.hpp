#pragma once

#include <array>
#include <cstddef>

namespace terravox::core {

/// Stands for no value in a band of an analysis: outside of the data, or behind a hole.
inline constexpr float kNoData = -9999;

/// So many values of a pixel may be measured.
inline constexpr std::size_t kMaxBands = 16;

/// The measured values of one pixel; those beyond its analysis are not used.
using Bands = std::array<float, kMaxBands>;

}  // namespace terravox::core
