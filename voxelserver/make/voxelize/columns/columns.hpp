#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "common/voxel/material.hpp"
#include "voxelserver/data/grid/patch.hpp"
#include "voxelserver/data/store/square.hpp"
#include "voxelserver/data/water/water_cells.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"

namespace terravox::voxelize {

inline constexpr float kNoHeight = std::numeric_limits<float>::quiet_NaN();

/// A height and what was seen at it. `height` is in voxels (continuous); NaN = nothing seen.
struct Surface {
    float height = kNoHeight;
    std::uint8_t source_class = 0;
    bool has_colour = false;
    voxel::Rgb8 colour;
    /// Mean of the points' brightness (store::VoxelPoint); 0 = not known.
    std::uint8_t brightness = 0;
    [[nodiscard]] bool seen() const noexcept { return height == height; }
};

/// A voxel that holds points of an object above the ground.
struct ObjectVoxel {
    std::int32_t y = 0;
    std::uint8_t source_class = 0;
    bool has_colour = false;
    voxel::Rgb8 colour;
    std::uint8_t fraction = 0;  ///< of its highest point within the voxel, 1/256 voxel
};

/// Summary of the points of one column, before any neighbour is considered.
struct Column {
    Surface ground;              ///< median of the ground points
    Surface roof;                ///< highest building point
    Surface water;               ///< median of the water points
    Surface deck;                ///< median of the bridge points
    float roof_low = kNoHeight;  ///< lowest building point
    /// Saturating counts.
    std::uint16_t ground_points = 0;
    std::uint16_t roof_points = 0;
    std::uint16_t water_points = 0;
    std::uint16_t deck_points = 0;
    /// Ground was seen beneath building points, not only next to them.
    bool roof_over_ground = false;
    /// Whether most of the low returns (ground, water, building) are of a building.
    [[nodiscard]] bool built_upon() const noexcept {
        return roof.seen() && roof_points >= ground_points + water_points;
    }
    /// Whether the classes of its points make it part of a bridge. Pulses that pass a railing or an
    /// edge hit what is below, so up to as many such points again are tolerated.
    [[nodiscard]] bool bridged() const noexcept {
        return deck.seen() && 2 * deck_points > ground_points + water_points;
    }
};

/// The 64 x 64 columns of a patch, index = z * 64 + x (local). Immutable.
struct PatchColumns {
    std::array<Column, grid::kPatchColumns> columns;
    std::vector<ObjectVoxel> objects;
    /// Objects of column i: [objects_begin[i], objects_begin[i + 1]), by rising y.
    std::array<std::uint32_t, grid::kPatchColumns + 1> objects_begin{};
    // The following are for steps that query many columns around, and small enough to stay in the
    // processor's cache. Bit x of row z stands for a column.
    /// The column holds any point.
    std::array<std::uint64_t, grid::kPatchSize> occupied{};
    /// The column is built_upon().
    std::array<std::uint64_t, grid::kPatchSize> built{};
    /// Ground was seen in the column.
    std::array<std::uint64_t, grid::kPatchSize> ground{};
    /// Water was seen in the column, at least as often as ground.
    std::array<std::uint64_t, grid::kPatchSize> wet{};
    std::array<float, grid::kPatchColumns> ground_height;  ///< of each column's ground
    bool any_roof = false;
    bool any_deck = false;
    bool any_objects = false;
    water::CellPatch cells;    ///< `covered` and `looks_wet` are set elsewhere
    float lowest = kNoHeight;  ///< of any point
    bool any = false;
    [[nodiscard]] const Column& at(int x, int z) const noexcept {
        return columns[static_cast<std::size_t>(z * grid::kPatchSize + x)];
    }
    [[nodiscard]] std::span<const ObjectVoxel> objects_at(int x, int z) const noexcept {
        const auto i = static_cast<std::size_t>(z * grid::kPatchSize + x);
        return std::span(objects).subspan(objects_begin[i],
                                          objects_begin[i + 1] - objects_begin[i]);
    }
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return sizeof *this + objects.capacity() * sizeof(ObjectVoxel) +
               cells.cells.capacity() * sizeof(water::WaterCell);
    }
};

/// The points of one square that fall into a patch, by column and rising height as Square keeps
/// them.
struct PatchPoints {
    std::span<const store::VoxelPoint> points;
    bool has_colour = false;
};

/// Step "column init": summarizes each column of a patch. The result does not depend on the order
/// of `sources`.
/// @param cell_voxels edge of a water cell: a divisor of 64
[[nodiscard]] std::shared_ptr<PatchColumns> init_columns(std::span<const PatchPoints> sources,
                                                         const ClassTable& classes,
                                                         int cell_voxels);

/// A patch with its eight neighbours: every step may read a margin of up to 64 columns, so that no
/// step can see a patch's edge. Coordinates are local to the middle patch: x, z in [-64, 128).
struct Window {
    static constexpr int kMargin = grid::kPatchSize;
    grid::PatchKey middle;
    std::array<std::shared_ptr<const PatchColumns>, 9> patches;  ///< index = (dz + 1) * 3 + dx + 1

    [[nodiscard]] const PatchColumns& patch_at(int x, int z) const noexcept {
        return *patches[static_cast<std::size_t>(((z >> 6) + 1) * 3 + (x >> 6) + 1)];
    }
    [[nodiscard]] const Column& column(int x, int z) const noexcept {
        return patch_at(x, z).at(x & 63, z & 63);
    }
    [[nodiscard]] std::span<const ObjectVoxel> objects(int x, int z) const noexcept {
        return patch_at(x, z).objects_at(x & 63, z & 63);
    }
    [[nodiscard]] float ground_height(int x, int z) const noexcept {
        return patch_at(x, z)
            .ground_height[static_cast<std::size_t>((z & 63) * grid::kPatchSize + (x & 63))];
    }
    [[nodiscard]] bool built(int x, int z) const noexcept {
        return (patch_at(x, z).built[static_cast<std::size_t>(z & 63)] >> (x & 63) & 1) != 0;
    }
    /// Calls visit(x, z) for each column of [first, last) x [first, last) that is built upon, row
    /// by row: most columns are not, and are passed 64 at a time.
    template <class Visit>
    void each_built(int first, int last, const Visit& visit) const {
        for (int z = first; z < last; ++z)
            for (int x0 = -kMargin; x0 < grid::kPatchSize + kMargin; x0 += grid::kPatchSize) {
                const int from = std::max(first - x0, 0);
                const int to = std::min(last - x0, grid::kPatchSize);
                if (from >= to)
                    continue;
                std::uint64_t left = patch_at(x0, z).built[static_cast<std::size_t>(z & 63)];
                left &= ~std::uint64_t{0} << from & ~std::uint64_t{0} >> (grid::kPatchSize - to);
                for (; left != 0; left &= left - 1)
                    visit(x0 + std::countr_zero(left), z);
            }
    }
    /// Whether any of the nine patches has `what`: most steps have nothing to do in most places.
    [[nodiscard]] bool any(bool PatchColumns::* what) const noexcept {
        return std::any_of(patches.begin(), patches.end(),
                           [&](const auto& p) { return (*p).*what; });
    }
};

/// A value for each column of a patch and a margin around it: x, z in [-Margin, 64 + Margin).
template <class T, int Margin>
class Grid {
public:
    static constexpr int kMargin = Margin;
    static constexpr int kSide = grid::kPatchSize + 2 * Margin;
    static constexpr int kFirst = -Margin;
    static constexpr int kLast = grid::kPatchSize + Margin;
    explicit Grid(const T& value = T{}) : m_values(kSide * kSide, value) {}
    [[nodiscard]] T& at(int x, int z) noexcept {
        return m_values[static_cast<std::size_t>((z + kMargin) * kSide + x + kMargin)];
    }
    [[nodiscard]] const T& at(int x, int z) const noexcept {
        return m_values[static_cast<std::size_t>((z + kMargin) * kSide + x + kMargin)];
    }
    [[nodiscard]] std::vector<T>& values() noexcept { return m_values; }
    [[nodiscard]] const std::vector<T>& values() const noexcept { return m_values; }

    template <class Visit>
    static void each(const Visit& visit) {
        for (int z = kFirst; z < kLast; ++z)
            for (int x = kFirst; x < kLast; ++x)
                visit(x, z);
    }

private:
    std::vector<T> m_values;
};

/// The grid that most steps after column init work on: runs query their neighbours for hidden
/// faces, and those query theirs for the shape of roofs.
template <class T>
using Margined = Grid<T, 2>;

}  // namespace terravox::voxelize
