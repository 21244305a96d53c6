#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "raytracer/core/base/analysis_bands.hpp"

namespace terravox::analyse {

/// A band of a raster.
struct RasterBand {
    std::string_view name;  ///< also the band's description in the file
    std::string_view unit;  ///< empty: none
    /// Index of the measured value; kDerived: computed from other bands of the raster.
    int measured;
};
inline constexpr int kDerived = -1;

/// The bands of an analysis, in the order of its files.
[[nodiscard]] std::span<const RasterBand> bands_of(core::AnalysisKind kind) noexcept;

/// Number of a band in the file, counted from 1.
/// @param name one of bands_of(kind)
[[nodiscard]] int band_number(core::AnalysisKind kind, std::string_view name);

}  // namespace terravox::analyse
