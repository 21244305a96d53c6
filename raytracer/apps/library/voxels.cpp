#include <terravox/world.hpp>

#include <algorithm>
#include <atomic>
#include <bit>
#include <string>

#include "common/util/error.hpp"
#include "raytracer/apps/library/box_columns.hpp"
#include "raytracer/apps/library/guarded.hpp"

namespace terravox {
namespace {

/// Copies the materials of a box into a grid.
class MaterialCopy {
public:
    MaterialCopy(const voxel::Box& box, VoxelGrid& grid) : m_box(box), m_grid(grid) {
        const voxel::BoxKey& key = box.key();
        m_x = key.bx * voxel::kBoxSizeX - grid.block.min[0];
        m_y = key.by * voxel::kBoxSizeY - grid.block.min[1];
        m_z = key.bz * voxel::kBoxSizeZ - grid.block.min[2];
    }

    [[nodiscard]] bool skips(int x, int z, int side) const noexcept {
        return m_x + x + side <= 0 || m_z + z + side <= 0 || m_x + x >= columns() ||
               m_z + z >= rows();
    }
    void hidden(int x, int y, int z, int side) {
        const int x0 = std::max(m_x + x, 0);
        const int x1 = std::min(m_x + x + side, columns());
        for (int v = std::max(m_y + y, 0); v < std::min(m_y + y + side, layers()); ++v)
            for (int w = std::max(m_z + z, 0); w < std::min(m_z + z + side, rows()); ++w)
                std::fill(&at(x0, v, w), &at(x0, v, w) + (x1 - x0),
                          static_cast<std::uint8_t>(voxel::Material::kRock));
    }
    void brick(int x, int y, int z, const voxel::TreeCell& cell) {
        for (std::uint64_t left = cell.mask; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            const int u = m_x + x + (bit & 3);
            const int v = m_y + y + (bit >> 4);
            const int w = m_z + z + (bit >> 2 & 3);
            if (u < 0 || v < 0 || w < 0 || u >= columns() || v >= layers() || w >= rows())
                continue;
            const bool known = (cell.detail >> bit & 1) != 0;
            at(u, v, w) = static_cast<std::uint8_t>(
                known ? m_box.attrs()[cell.compute_index(bit)].material : voxel::Material::kRock);
        }
    }

private:
    [[nodiscard]] int layers() const noexcept { return static_cast<int>(m_grid.shape[0]); }
    [[nodiscard]] int rows() const noexcept { return static_cast<int>(m_grid.shape[1]); }
    [[nodiscard]] int columns() const noexcept { return static_cast<int>(m_grid.shape[2]); }
    [[nodiscard]] std::uint8_t& at(int u, int v, int w) noexcept {
        return m_grid.materials[(static_cast<std::size_t>(v) * m_grid.shape[1] +
                                 static_cast<std::size_t>(w)) *
                                    m_grid.shape[2] +
                                static_cast<std::size_t>(u)];
    }

    const voxel::Box& m_box;
    VoxelGrid& m_grid;
    int m_x = 0;  ///< of the box's lowest corner in the grid
    int m_y = 0;
    int m_z = 0;
};

/// Far coordinates would not fit their type at other levels, or as bytes of an array.
void check_range(std::int32_t coordinate, int level) {
    constexpr std::int64_t kFarthest = std::int64_t{1} << 30;
    const std::int64_t finest = std::int64_t{coordinate} * (std::int64_t{1} << level);
    if (finest < -kFarthest || finest > kFarthest)
        throw util::UsageError("read voxels: the block reaches to " + std::to_string(coordinate) +
                               " on level " + std::to_string(level) +
                               "; allowed: -2^30 to 2^30 on level 0");
}

VoxelGrid make_grid(const VoxelBlock& block, const MapFrame& frame) {
    constexpr double kMost = 4294967296.0;
    VoxelGrid out;
    out.block = block;
    voxel::VoxelBounds finest{block.min, block.max};
    double count = 1;
    for (std::size_t a = 0; a < 3; ++a) {
        check_range(block.min[a], block.level);
        check_range(block.max[a], block.level);
        const std::int64_t size = std::int64_t{block.max[a]} - block.min[a];
        if (size <= 0)
            throw util::UsageError("read voxels: the block has " + std::to_string(size) +
                                   " along an axis; allowed: at least 1");
        count *= static_cast<double>(size);
        // Axes x, y, z of the world are the last, first and second of the array.
        out.shape[a == 0 ? 2 : a == 1 ? 0 : 1] = static_cast<std::size_t>(size);
        finest.min[a] *= std::int32_t{1} << block.level;
        finest.max[a] *= std::int32_t{1} << block.level;
    }
    if (count > kMost)
        throw util::UsageError("read voxels: the block has " + std::to_string(count) +
                               "; allowed: up to 2^32");
    out.bounds = frame.measure_bounds(finest);
    out.materials.resize(out.shape[0] * out.shape[1] * out.shape[2]);
    return out;
}

}  // namespace

VoxelGrid World::voxels(const VoxelBlock& block, int threads, const Control& control) const {
    return guarded(control, [&] {
        const WorldCall call(*m_state, threads);
        m_state->check_level(block.level);
        VoxelGrid out = make_grid(block, m_state->frame);
        std::atomic<std::size_t> holes{0};
        const voxel::VoxelBounds bounds{block.min, block.max};
        each_box_column(bounds, block.level, threads, control, [&](const BoxColumnAt& column) {
            for (std::int32_t by = column.by_begin; by < column.by_end; ++by) {
                const auto found = m_state->blocks.get({block.level, column.bx, by, column.bz});
                if (found->hole)
                    ++holes;
                if (!found->box)
                    continue;
                MaterialCopy copy(*found->box, out);
                walk_tree(*found->box, copy);
            }
        });
        out.holes = call.checked(holes);
        return out;
    });
}

}  // namespace terravox
