#include <terravox/world.hpp>

#include <array>
#include <atomic>
#include <bit>
#include <limits>
#include <string>

#include "common/util/error.hpp"
#include "raytracer/apps/library/box_columns.hpp"
#include "raytracer/apps/library/guarded.hpp"

namespace terravox {
namespace {

/// The upper faces of the highest voxels of a column of boxes, from its boxes, the highest first.
class ColumnHeights {
public:
    static constexpr int kSide = voxel::kBoxSizeX;
    static constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::min();

    ColumnHeights() {
        m_open.fill(~std::uint64_t{0});
        m_tops.fill(kNone);
    }

    void add(const voxel::Box& box) {
        m_y = box.key().by * voxel::kBoxSizeY;
        walk_tree(box, *this);
    }
    /// Whether no column is without a height.
    [[nodiscard]] bool is_full() const noexcept {
        return std::all_of(m_open.begin(), m_open.end(),
                           [](std::uint64_t row) { return row == 0; });
    }
    /// In voxels of the boxes' level; kNone: nothing is there.
    [[nodiscard]] std::int32_t at(int x, int z) const noexcept {
        return m_tops[static_cast<std::size_t>(z * kSide + x)];
    }

    [[nodiscard]] bool skips(int x, int z, int side) const noexcept {
        const std::uint64_t wanted = bits(x, side);
        for (int row = z; row < z + side; ++row)
            if ((m_open[static_cast<std::size_t>(row)] & wanted) != 0)
                return false;
        return true;
    }
    void hidden(int x, int y, int z, int side) {
        for (int row = z; row < z + side; ++row)
            set(row, bits(x, side), y + side);
    }
    void brick(int x, int y, int z, const voxel::TreeCell& cell) {
        for (int v = 3; v >= 0; --v) {
            const auto layer = static_cast<std::uint32_t>(cell.mask >> (16 * v) & 0xFFFF);
            for (int row = 0; row < 4 && layer != 0; ++row)
                set(z + row, std::uint64_t{layer >> (4 * row) & 15} << x, y + v + 1);
        }
    }

private:
    [[nodiscard]] static std::uint64_t bits(int x, int side) noexcept {
        return (side == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << side) - 1) << x;
    }
    void set(int row, std::uint64_t columns, int top) noexcept {
        std::uint64_t& open = m_open[static_cast<std::size_t>(row)];
        for (std::uint64_t left = open & columns; left != 0; left &= left - 1)
            m_tops[static_cast<std::size_t>(row * kSide + std::countr_zero(left))] = m_y + top;
        open &= ~columns;
    }

    std::int32_t m_y = 0;
    std::array<std::uint64_t, kSide> m_open{};  ///< rows of columns without a height
    std::array<std::int32_t, static_cast<std::size_t>(kSide) * kSide> m_tops{};
};

class SurfaceReader {
public:
    SurfaceReader(blocks::BlockManager& blocks, const voxel::VoxelBounds& block, int level,
                  double voxel_m, Raster& out)
        : m_blocks(blocks), m_block(block), m_level(level), m_voxel_m(voxel_m), m_out(out) {}

    void read(const BoxColumnAt& column) {
        ColumnHeights heights;
        for (std::int32_t by = column.by_end; by-- > column.by_begin && !heights.is_full();) {
            const auto found = m_blocks.get({m_level, column.bx, by, column.bz});
            if (found->hole) {
                // What is below may be covered by what could not be read.
                ++m_holes;
                return;
            }
            if (found->box)
                heights.add(*found->box);
        }
        write(column, heights);
    }
    [[nodiscard]] std::size_t holes() const noexcept { return m_holes; }

private:
    void write(const BoxColumnAt& column, const ColumnHeights& heights) {
        for (int z = 0; z < ColumnHeights::kSide; ++z) {
            const std::int32_t row = column.bz * ColumnHeights::kSide + z - m_block.min[2];
            if (row < 0 || row >= m_block.max[2] - m_block.min[2])
                continue;
            for (int x = 0; x < ColumnHeights::kSide; ++x) {
                const std::int32_t at = column.bx * ColumnHeights::kSide + x - m_block.min[0];
                const std::int32_t top = heights.at(x, z);
                if (at < 0 || at >= m_block.max[0] - m_block.min[0] || top == ColumnHeights::kNone)
                    continue;
                m_out.bands.front().values[static_cast<std::size_t>(row) * m_out.columns +
                                           static_cast<std::size_t>(at)] =
                    static_cast<float>(static_cast<double>(top) * m_voxel_m);
            }
        }
    }

    blocks::BlockManager& m_blocks;
    const voxel::VoxelBounds m_block;  ///< of the level
    const int m_level;
    const double m_voxel_m;  ///< of the level
    Raster& m_out;
    std::atomic<std::size_t> m_holes{0};
};

/// Worlds without end are wider than any memory.
void check_size(const voxel::VoxelBounds& block) {
    constexpr double kMost = 1e9;
    const double cells = (static_cast<double>(block.max[0]) - block.min[0]) *
                         (static_cast<double>(block.max[2]) - block.min[2]);
    if (cells > kMost)
        throw util::UsageError("read a surface: " + std::to_string(cells) +
                               " cells; allowed: up to 10^9");
}

}  // namespace

Raster World::surface(const std::optional<MapBounds>& area, int level, int threads,
                      const Control& control) const {
    return guarded(control, [&] {
        const WorldCall call(*m_state, threads);
        const voxel::VoxelBounds block = m_state->columns_over(area, level);
        voxel::VoxelBounds finest = block;
        for (std::size_t a = 0; a < 3; ++a) {
            finest.min[a] *= std::int32_t{1} << level;
            finest.max[a] *= std::int32_t{1} << level;
        }
        Raster out;
        out.bounds = m_state->frame.measure_bounds(finest);
        out.cell = m_state->frame.units() * static_cast<double>(std::int64_t{1} << level);
        check_size(block);
        out.rows = static_cast<std::size_t>(block.max[2] - block.min[2]);
        out.columns = static_cast<std::size_t>(block.max[0] - block.min[0]);
        out.bands.push_back(
            {"height", "m",
             std::vector<float>(out.rows * out.columns, std::numeric_limits<float>::quiet_NaN())});
        const double voxel_m =
            m_state->info.voxel_m * static_cast<double>(std::int64_t{1} << level);
        SurfaceReader reader(m_state->blocks, block, level, voxel_m, out);
        each_box_column(block, level, threads, control,
                        [&](const BoxColumnAt& column) { reader.read(column); });
        out.holes = call.checked(reader.holes());
        return out;
    });
}

}  // namespace terravox
