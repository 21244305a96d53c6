#include "raytracer/core/walk/solid_query.hpp"

#include <array>

namespace terravox::walk {
namespace {

using voxel::TreeCell;

/// Bits of the children of a cell from index a to b on one axis.
struct AxisMasks {
    std::array<std::array<std::uint64_t, 4>, 4> of[3]{};
    constexpr AxisMasks() {
        constexpr std::uint64_t plane[3] = {0x1111'1111'1111'1111, 0xffff, 0x000f'000f'000f'000f};
        constexpr int shift[3] = {1, 16, 4};
        for (int axis = 0; axis < 3; ++axis)
            for (std::size_t a = 0; a < 4; ++a)
                for (std::size_t b = a; b < 4; ++b)
                    for (std::size_t k = a; k <= b; ++k)
                        of[axis][a][b] |= plane[axis] << (static_cast<int>(k) * shift[axis]);
    }
};
constexpr AxisMasks kMasks;

/// Bits of the children, 2^shift voxels wide, of the cell at `base` that the range touches; the
/// range touches the cell.
[[gnu::always_inline]] inline std::uint64_t touched(const VoxelRange& range,
                                                    const std::int32_t (&base)[3],
                                                    int shift) noexcept {
    const auto child = [&](std::int32_t v, int axis) {
        return static_cast<std::size_t>(std::clamp((v - base[axis]) >> shift, 0, 3));
    };
    return kMasks.of[0][child(range.low[0], 0)][child(range.high[0], 0)] &
           kMasks.of[1][child(range.low[1], 1)][child(range.high[1], 1)] &
           kMasks.of[2][child(range.low[2], 2)][child(range.high[2], 2)];
}

constexpr int kTopShift = 4, kMiddleShift = 2;  // children of a root, and of its children

}  // namespace

bool SolidQuery::any_solid(const VoxelRange& wanted, int grain_shift) {
    const voxel::VoxelBounds& bounds = m_cut.entry_bounds();
    VoxelRange range;
    for (int a = 0; a < 3; ++a) {
        const auto i = static_cast<std::size_t>(a);
        range.low[a] = std::max(wanted.low[a], bounds.min[i]);
        range.high[a] = std::min(wanted.high[a], bounds.max[i] - 1);
        if (range.low[a] > range.high[a])
            return false;
    }
    m_level = m_cut.level_at(range.low[0], range.low[2], m_level);
    const int side = LevelCut::kSideBits + m_level;
    const int start = m_level;
    for (std::int32_t bx = range.low[0] >> side; bx <= range.high[0] >> side; ++bx)
        for (std::int32_t bz = range.low[2] >> side; bz <= range.high[2] >> side; ++bz) {
            // Another part of the range may be coarser, or finer.
            const int up = std::max(m_cut.level_at(bx << side, bz << side, start) - start, 0);
            if (column(start + up, bx >> up, bz >> up, range, grain_shift))
                return true;
        }
    return false;
}

// A column of `level` or of finer ones.
bool SolidQuery::column(int level, std::int32_t bx, std::int32_t bz, const VoxelRange& range,
                        int grain_shift) {
    if (!m_cut.far_enough(level, bx, bz)) {
        const int side = LevelCut::kSideBits + level - 1;
        for (int half = 0; half < 4; ++half) {
            const std::int32_t x = bx * 2 + (half & 1);
            const std::int32_t z = bz * 2 + (half >> 1);
            if (range.high[0] >> side < x || range.low[0] >> side > x ||
                range.high[2] >> side < z || range.low[2] >> side > z)
                continue;
            if (column(level - 1, x, z, range, grain_shift))
                return true;
        }
        return false;
    }
    VoxelRange local;
    for (int a = 0; a < 3; ++a) {
        local.low[a] = range.low[a] >> level;
        local.high[a] = range.high[a] >> level;
    }
    for (std::int32_t by = local.low[1] >> 8; by <= local.high[1] >> 8; ++by) {
        const blocks::Block* block = m_reader.get({level, bx, by, bz});
        if (block == nullptr || block->hole)
            return true;
        if (!block->box)
            continue;
        VoxelRange inside = local;
        const std::int32_t origin[3] = {bx << 6, by << 8, bz << 6}, size[3] = {64, 256, 64};
        for (int a = 0; a < 3; ++a) {
            inside.low[a] = std::max(local.low[a] - origin[a], 0);
            inside.high[a] = std::min(local.high[a] - origin[a], size[a] - 1);
        }
        if (box(*block->box, inside, std::max(grain_shift - level, 0)))
            return true;
    }
    return false;
}

// `local` in the box's own voxels.
bool SolidQuery::box(const voxel::Box& box, const VoxelRange& local, int grain_shift) {
    const TreeCell* cells = box.cells().data();
    for (std::int32_t root_y = local.low[1] >> 6; root_y <= local.high[1] >> 6; ++root_y) {
        const TreeCell& root = cells[root_y];
        const std::int32_t base[3] = {0, root_y << 6, 0};
        std::uint64_t top = root.mask & touched(local, base, kTopShift);
        if (top != 0 && grain_shift >= kTopShift)
            return true;
        for (; top != 0; top &= top - 1) {
            const int bit = std::countr_zero(top);
            if ((root.detail >> bit & 1) == 0)
                return true;
            const TreeCell& middle = cells[root.compute_index(bit)];
            const std::int32_t low[3] = {base[0] + (bit & 3) * 16, base[1] + (bit >> 4) * 16,
                                         base[2] + (bit >> 2 & 3) * 16};
            std::uint64_t bricks = middle.mask & touched(local, low, kMiddleShift);
            if (bricks != 0 && grain_shift >= kMiddleShift)
                return true;
            for (; bricks != 0; bricks &= bricks - 1) {
                const int at = std::countr_zero(bricks);
                if ((middle.detail >> at & 1) == 0)
                    return true;
                const std::int32_t brick[3] = {low[0] + (at & 3) * 4, low[1] + (at >> 4) * 4,
                                               low[2] + (at >> 2 & 3) * 4};
                if ((cells[middle.compute_index(at)].mask & touched(local, brick, 0)) != 0)
                    return true;
            }
        }
    }
    return false;
}

}  // namespace terravox::walk
