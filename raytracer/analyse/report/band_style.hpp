#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "voxelserver/serve/map/pixels.hpp"

namespace terravox::analyse {

/// How values become colours.
enum class Ramp : std::uint8_t {
    kHeights,    ///< green lowland to white summits
    kMuch,       ///< dark blue to yellow: shares, angles
    kWarm,       ///< black to light yellow: sun and energy
    kAround,     ///< directions: 0 and 360 degrees have the same colour
    kGrey,       ///< hillshade
    kClasses,    ///< LiDAR classes, a colour each
    kMaterials,  ///< materials, a colour each
};
[[nodiscard]] constexpr bool has_categories(Ramp ramp) noexcept {
    return ramp == Ramp::kClasses || ramp == Ramp::kMaterials;
}

/// The band of each analysis that is 1 where data could not be read.
inline constexpr std::string_view kHoleBand = "hole";

/// How a band is drawn as a map. A band without one is in the report's table only.
struct BandStyle {
    std::string_view band;   ///< its name in the raster
    std::string_view title;  ///< of its map
    Ramp ramp;
    /// Ends of the scale; nullopt: by the values.
    std::optional<double> low;
    std::optional<double> high;
};

/// @return nullptr for a band without a map
[[nodiscard]] const BandStyle* choose_style(std::string_view band) noexcept;

/// @param share of the scale, clamped to [0, 1]
[[nodiscard]] map::Rgba8 colour_at(Ramp ramp, double share) noexcept;

/// @param ramp one with categories
[[nodiscard]] map::Rgba8 colour_of_category(Ramp ramp, int number) noexcept;
[[nodiscard]] std::string name_of_category(Ramp ramp, int number);

}  // namespace terravox::analyse
