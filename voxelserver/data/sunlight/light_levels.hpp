#pragma once

#include <optional>
#include <span>

#include "voxelserver/data/sunlight/sunlit.hpp"

namespace terravox::sunlight {

/// The light of one flight: what a photograph's values must be divided by.
struct FlightLight {
    std::optional<Sun> sun;  ///< nullopt: not found; then only `gain` counts
    /// Light in the shadow over light in the sun, on flat ground, by channel: (0, 1].
    Light sky{1, 1, 1};
    Light veil{};         ///< what the air between adds to every value, linear
    Light gain{1, 1, 1};  ///< for exposure and white balance
    /// Median luminance of what lies in the sun, without the veil, by kind; 0 = not known.
    std::array<float, kKinds> typical{};
};

/// What is seen, less the veil; never below 0.
[[nodiscard]] Light without_veil(const Light& seen, const Light& veil) noexcept;

/// Measures sky, veil and gain. Each is a median or a percentile over the scenes; what cannot be
/// measured has the value that changes nothing. The gain brings back what haze took away, as its
/// veil tells; otherwise it is 1 while brightness and hue of crowns and grass lie in the range that
/// they have in nature.
/// @param scenes parts of one photograph, without gaps (fill_gaps)
[[nodiscard]] FlightLight measure_light(std::span<const Scene> scenes,
                                        const std::optional<Sun>& sun);

}  // namespace terravox::sunlight
