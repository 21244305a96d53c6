#pragma once

#include <array>
#include <span>

#include "voxelserver/data/sunlight/light_levels.hpp"

namespace terravox::sunlight {

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
