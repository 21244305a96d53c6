#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "voxelserver/make/voxelize/columns/columns.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/steps/ground_fill.hpp"

namespace terravox::voxelize {

/// Roof columns that touch without a step between them.
struct Building {
    /// The absolute voxel of its northernmost column, of these the westernmost: the same for every
    /// patch that the building reaches into.
    std::int32_t x = 0;
    std::int32_t z = 0;
    std::uint32_t columns = 0;
};

/// Which roof columns of a window are one building. A building wider than kWidest columns along an
/// axis is none: its end may lie beyond the window, and two patches would not agree about it.
class Buildings {
public:
    static constexpr int kWidest = 47;
    /// Buildings are known that reach into [-kAround, 64 + kAround) along both axes.
    static constexpr int kAround = 16;

    Buildings(const Window& window, double voxel_m);

    /// @param x, z in [-64, 128)
    /// @return nullptr where no returns of a roof are, for what is too wide, and for what does not
    /// reach near the patch
    [[nodiscard]] const Building* at(int x, int z) const noexcept;
    /// All of them; at() points into these.
    [[nodiscard]] std::span<const Building> all() const noexcept { return m_buildings; }

private:
    std::vector<Building> m_buildings;
    /// For each column of the window: index into m_buildings, or -1. Empty = none.
    std::vector<std::int16_t> m_index;
};

/// What stands in a column: a roof, and the wall below it down to the ground, unless it is open
/// beneath.
struct Roof {
    Surface top;
    /// Lowest height that was seen of an arcade, canopy or balcony, voxels; NaN = down to the
    /// ground.
    float bottom = kNoHeight;
    /// The column whose appearance a closed gap takes, relative to this one.
    std::int8_t appearance_dx = 0;
    std::int8_t appearance_dz = 0;
    [[nodiscard]] bool seen() const noexcept { return top.seen(); }
    [[nodiscard]] bool open_beneath() const noexcept { return bottom == bottom; }
};

/// Step "building fill": roofs without holes, and which of them are open beneath.
///
/// A column is built upon when most of its low returns (ground, water, building) are of buildings,
/// so that footprints are neither widened nor narrowed. Gaps between points in a roof take the
/// median of the roofs around. A roof is open beneath where ground was seen below it by more than a
/// storey (not only next to it: an edge that cuts through a column is a wall), and between such
/// places, or between one and a higher wall: few pulses reach far under a roof. Its thickness is
/// what was seen of it; a tall building keeps all but its lowest storey (a passage).
[[nodiscard]] Margined<Roof> fill_buildings(const Window& window,
                                            const Settings::Buildings& settings, double voxel_m);

/// The columns' own building points and nothing else, for when the step is switched off.
[[nodiscard]] Margined<Roof> seen_roofs(const Window& window);

}  // namespace terravox::voxelize
