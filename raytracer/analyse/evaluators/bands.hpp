#pragma once

#include <type_traits>

#include "raytracer/core/base/analysis_bands.hpp"

namespace terravox::analyse {

/// The value of a band of a cell.
/// @param band core::TerrainBand, core::SkyBand
template <class Band>
[[nodiscard]] float& at(core::Bands& bands, Band band) noexcept {
    static_assert(std::is_enum_v<Band>);
    return bands[static_cast<std::size_t>(band)];
}

/// Bands without any value.
/// @param hole number of the band that counts holes
/// @param is_hole whether a box that is not available is the reason
[[nodiscard]] inline core::Bands no_values(std::size_t hole, bool is_hole) noexcept {
    core::Bands out;
    out.fill(core::kNoData);
    out[hole] = is_hole ? 1.0F : 0.0F;
    return out;
}
template <class Band>
[[nodiscard]] core::Bands no_values(Band hole, bool is_hole) noexcept {
    static_assert(std::is_enum_v<Band>);
    return no_values(static_cast<std::size_t>(hole), is_hole);
}

}  // namespace terravox::analyse
