#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/analyse/report/band_style.hpp"

namespace terravox::analyse {

/// What the values of a band are like. Cells without a value are left out.
struct BandStatistics {
    static constexpr std::size_t kBins = 256;

    std::uint64_t cells = 0;  ///< that have a value; with 0 of them the rest means nothing
    double min = 0;
    double max = 0;
    double mean = 0;
    std::array<std::uint64_t, kBins> bins{};  ///< of equal width, from min to max

    /// The value below which a share of the cells lies, to the width of a bin.
    /// @param share [0, 1]
    [[nodiscard]] double quantile(double share) const noexcept;
};

/// Reads a band twice, block by block, so that it may be larger than memory.
/// @throws Error "interrupted" when stopped, and as CellFile
[[nodiscard]] BandStatistics measure_statistics(CellFile& cells, std::string_view band,
                                                const std::stop_token& stop);

/// How many cells have each number, of a band of categories.
/// @throws as measure_statistics()
[[nodiscard]] std::map<int, std::uint64_t> count_values(CellFile& cells, std::string_view band,
                                                        const std::stop_token& stop);

/// A mark of a scale.
struct Tick {
    double share = 0;  ///< of the scale, [0, 1]
    std::string label;
};

/// A category that is there.
struct LegendEntry {
    int number = 0;
    std::string name;
    map::Rgba8 colour;
    double share = 0;  ///< of the cells that have a value
};

/// What the colours of a map stand for: a scale with ticks, or categories.
struct Legend {
    Ramp ramp = Ramp::kGrey;
    double low = 0;
    double high = 1;  ///< above low
    std::vector<Tick> ticks;
    std::vector<LegendEntry> entries;  ///< the most frequent ones first

    [[nodiscard]] map::Rgba8 to_colour(double value) const noexcept;
};

/// The scale of a band: from the style's ends or, where it has none, from round numbers around the
/// values without the outermost hundredth on each side.
[[nodiscard]] Legend scale_for(const BandStyle& style, const BandStatistics& statistics);

/// The legend of a band of categories.
[[nodiscard]] Legend categories_for(const BandStyle& style,
                                    const std::map<int, std::uint64_t>& counts);

/// A round number (1, 2 or 5 times a power of ten) that fits about `count` times into a length.
/// @param length above 0
[[nodiscard]] double round_step(double length, int count) noexcept;

/// Shares are shown to a tenth of a per cent.
inline constexpr double kPercentStep = 0.1;

/// With as many decimals as a step needs.
[[nodiscard]] std::string number_text(double value, double step);

/// The area of cells, in square metres, hectares or square kilometres.
[[nodiscard]] std::string area_text(double cells, double cell_m);

}  // namespace terravox::analyse
