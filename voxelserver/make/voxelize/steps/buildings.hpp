#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "voxelserver/make/voxelize/columns/window.hpp"

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

}  // namespace terravox::voxelize
