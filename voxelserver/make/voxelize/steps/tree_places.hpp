#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "voxelserver/make/voxelize/columns/window.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"

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
    static constexpr int kSide = grid::kPatchSize + 2 * kMargin;
    static constexpr std::size_t kCount = std::size_t{kSide} * kSide;

    struct Place {
        std::int16_t x = 0;
        std::int16_t z = 0;
    };
    /// @param x, z in [-kMargin, 64 + kMargin)
    [[nodiscard]] static constexpr std::size_t index(int x, int z) noexcept {
        return static_cast<std::size_t>((z + kMargin) * kSide + x + kMargin);
    }
    [[nodiscard]] std::int64_t top(const ObjectVoxel& highest) const noexcept;
    [[nodiscard]] Place uphill(Place from) const noexcept;

    const Window& m_window;
    const ClassTable& m_classes;
    int m_radius;
    // Of the patch's columns and a margin of kMargin around them, by index().
    std::vector<std::int64_t> m_tops;  ///< top()
    std::vector<Place> m_next;         ///< the next place uphill, once it is known
    std::vector<char> m_known;
};

}  // namespace terravox::voxelize
