#pragma once

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>

#include "common/voxel/box.hpp"

namespace terravox::grid {

/// Columns are grouped into patches of 64 x 64, the footprint of a level-0 box.
inline constexpr int kPatchSize = 64;
inline constexpr int kPatchColumns = kPatchSize * kPatchSize;
static_assert(kPatchSize == voxel::kBoxSizeX && kPatchSize == voxel::kBoxSizeZ);

/// The index of a patch: floor(x / 64), floor(z / 64) of its absolute voxels.
struct PatchKey {
    std::int32_t px = 0;
    std::int32_t pz = 0;
    /// First column, in absolute voxels.
    [[nodiscard]] std::int32_t x0() const noexcept { return px * kPatchSize; }
    [[nodiscard]] std::int32_t z0() const noexcept { return pz * kPatchSize; }
    friend auto operator<=>(const PatchKey& a, const PatchKey& b) noexcept {
        return a.pz != b.pz ? a.pz <=> b.pz : a.px <=> b.px;  // row by row, north to south
    }
    friend bool operator==(const PatchKey&, const PatchKey&) = default;
};
struct PatchKeyHash {
    std::size_t operator()(const PatchKey& k) const noexcept {
        return static_cast<std::size_t>(voxel::morton_encode(k.px, 0, k.pz));
    }
};

/// A rectangle of columns in absolute voxels, half-open.
struct ColumnRect {
    std::int32_t min_x = 0;
    std::int32_t min_z = 0;
    std::int32_t max_x = 0;
    std::int32_t max_z = 0;
    [[nodiscard]] bool overlaps(const ColumnRect& o) const noexcept {
        return min_x < o.max_x && o.min_x < max_x && min_z < o.max_z && o.min_z < max_z;
    }
    [[nodiscard]] ColumnRect grown(std::int32_t by) const noexcept {
        return {min_x - by, min_z - by, max_x + by, max_z + by};
    }
    /// What both cover; its area is 0 where that is nothing.
    [[nodiscard]] ColumnRect common(const ColumnRect& o) const noexcept {
        return {std::max(min_x, o.min_x), std::max(min_z, o.min_z), std::min(max_x, o.max_x),
                std::min(max_z, o.max_z)};
    }
    /// The number of columns; 0 where a side is not positive. Sides count up to 2^29 columns, more
    /// than the Earth is long: an image without a sensible place may state any.
    [[nodiscard]] std::int64_t area() const noexcept {
        const auto side = [](std::int32_t min, std::int32_t max) {
            constexpr std::int64_t kLongest = std::int64_t{1} << 29;
            return std::clamp<std::int64_t>(std::int64_t{max} - min, 0, kLongest);
        };
        return side(min_x, max_x) * side(min_z, max_z);
    }
    friend bool operator==(const ColumnRect&, const ColumnRect&) = default;
};

[[nodiscard]] inline ColumnRect find_columns(PatchKey k) noexcept {
    return {k.x0(), k.z0(), k.x0() + kPatchSize, k.z0() + kPatchSize};
}

/// The patches that cover a rectangle of columns, half-open.
struct PatchRect {
    PatchKey min;
    PatchKey max;
    [[nodiscard]] bool contains(PatchKey k) const noexcept {
        return k.px >= min.px && k.px < max.px && k.pz >= min.pz && k.pz < max.pz;
    }
};

}  // namespace terravox::grid
