#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "voxelserver/make/voxelize/columns/columns.hpp"

namespace terravox::voxelize {

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
