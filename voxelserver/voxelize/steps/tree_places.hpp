#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxelserver/voxelize/columns/window.hpp"
#include "voxelserver/voxelize/points/class_table.hpp"

namespace terravox::voxelize {

/// Which tree the foliage over a column belongs to: that of the local maximum of the canopy that
/// lies uphill. Climbs by the highest column around, at most kJumps times, and so sees a few
/// columns beyond the patch, the same from every patch.
class TreePlaces {
public:
    TreePlaces(const Window& window, const ClassTable& classes, double voxel_m);

    /// @param x, z in [-2, 66)
    /// @return the absolute voxels (x, z) of the tree's highest column
    [[nodiscard]] std::array<std::int32_t, 2> at(int x, int z);

private:
    static constexpr int kJumps = 6;
    static constexpr int kMaxRadius = 4;
    static constexpr int kMargin = 2 + kMaxRadius * (kJumps + 1);
    static_assert(kMargin < Window::kMargin);

    struct Place {
        std::int16_t x = 0;
        std::int16_t z = 0;
    };
    [[nodiscard]] std::int64_t top(int x, int z) const noexcept;
    [[nodiscard]] Place uphill(Place from) const noexcept;

    const Window& m_window;
    const ClassTable& m_classes;
    int m_radius;
    /// Of each column with its margin: the next place uphill, once it is known.
    std::vector<Place> m_next;
    std::vector<char> m_known;
};

}  // namespace terravox::voxelize
