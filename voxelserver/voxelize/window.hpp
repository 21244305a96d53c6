#pragma once

#include <array>
#include <memory>
#include <vector>

#include "voxelserver/voxelize/columns.hpp"

namespace terravox::voxelize {

/// A patch with its eight neighbours: every step may read a margin of up to 64 columns, so that no step can see a patch's edge.
/// Coordinates are local to the middle patch: x, z in [-64, 128).
struct Window {
    std::array<std::shared_ptr<const PatchColumns>, 9> patches;  ///< index = (dz + 1) * 3 + dx + 1

    [[nodiscard]] const PatchColumns& patch_at(int x, int z) const noexcept {
        return *patches[static_cast<std::size_t>(((z >> 6) + 1) * 3 + (x >> 6) + 1)];
    }
    [[nodiscard]] const Column& column(int x, int z) const noexcept {
        return patch_at(x, z).columns[static_cast<std::size_t>((z & 63) * kPatchSize + (x & 63))];
    }
};

/// Columns that the steps after column init work on: the middle patch with a margin of 2 (roof filling asks its neighbours, and
/// hidden faces ask theirs). x, z in [-2, 66).
template <class T> class Margined {
public:
    static constexpr int kMargin = 2, kSide = kPatchSize + 2 * kMargin;
    explicit Margined(const T& value = T{}) : m_values(kSide * kSide, value) {}
    [[nodiscard]] T& at(int x, int z) noexcept { return m_values[static_cast<std::size_t>((z + kMargin) * kSide + x + kMargin)]; }
    [[nodiscard]] const T& at(int x, int z) const noexcept { return m_values[static_cast<std::size_t>((z + kMargin) * kSide + x + kMargin)]; }

private:
    std::vector<T> m_values;
};

}  // namespace terravox::voxelize
