#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "voxelserver/make/voxelize/columns/window.hpp"
#include "voxelserver/make/voxelize/points/placer.hpp"

namespace terravox::voxelize {

/// Which columns lie inside the stated bounds of some file: elsewhere there is nothing, not even
/// rock. Coordinates are absolute voxels. Immutable, thread-safe.
class SurveyBounds {
public:
    /// @param files must outlive this
    explicit SurveyBounds(std::span<const SquareSource> files) : m_files(files) {}

    [[nodiscard]] bool contains(std::int32_t x, std::int32_t z) const noexcept {
        return std::any_of(m_files.begin(), m_files.end(),
                           [&](const SquareSource& s) { return s.on_island(x, z); });
    }

    /// Whether a single part of the bounds of some file holds the whole rectangle.
    [[nodiscard]] bool surrounds(const grid::ColumnRect& rect) const noexcept;

    /// The same as contains() for all columns of the window around a patch: 1 = inside.
    [[nodiscard]] Grid<char, Window::kMargin> around(grid::PatchKey middle) const;

private:
    const std::span<const SquareSource> m_files;
};

}  // namespace terravox::voxelize
