#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raytracer/analyse/report/band_statistics.hpp"
#include "raytracer/analyse/report/band_style.hpp"

namespace terravox::analyse {

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

    [[nodiscard]] map::Rgba8 colour_of(double value) const noexcept;
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

}  // namespace terravox::analyse
