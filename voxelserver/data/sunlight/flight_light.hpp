#pragma once

#include <array>
#include <optional>
#include <span>

#include "voxelserver/data/sunlight/sun.hpp"

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

/// Whether a colour may be that of leaves or grass, whatever the exposure.
[[nodiscard]] bool is_leaf_green(const Light& seen) noexcept;

/// Measures sky, veil and gain. Each is a median or a percentile over the scenes; what cannot be
/// measured has the value that changes nothing. The gain brings back what haze took away, as its
/// veil tells; otherwise it is 1 while brightness and hue of crowns and grass lie in the range that
/// they have in nature.
/// @param scenes parts of one photograph, without gaps (fill_gaps)
[[nodiscard]] FlightLight measure_light(std::span<const Scene> scenes,
                                        const std::optional<Sun>& sun);

/// Whether two photographs may be of one flight: their suns are at most 5 degrees apart.
[[nodiscard]] bool is_same_flight(const Sun& a, const Sun& b) noexcept;

struct WeightedLight {
    FlightLight light;
    float weight = 1;
};
/// The weighted mean of lights of one flight.
/// @param lights all with a sun, not empty; weights not negative, one of them at least positive
[[nodiscard]] FlightLight blended(std::span<const WeightedLight> lights);

/// The light over a square of cells: that of its middle, and at its corners what changes slowly
/// across it. Photographs of one mosaic so join without a seam.
struct LightField {
    /// What a cell's light is divided out by, besides the sun.
    struct Levels {
        Light sky;
        Light veil;
        Light gain;
    };

    /// The same everywhere.
    explicit LightField(const FlightLight& light) noexcept;
    /// @param corners north-west, north-east, south-west, south-east
    LightField(const FlightLight& middle, const std::array<FlightLight, 4>& corners) noexcept;

    /// @param east,south from the north-western corner, in sides of the square; linear beyond
    [[nodiscard]] Levels at(float east, float south) const noexcept;

    FlightLight middle;
    std::array<Levels, 4> corners;
};

}  // namespace terravox::sunlight
