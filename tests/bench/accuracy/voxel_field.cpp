#include "tests/bench/accuracy/voxel_field.hpp"

#include <limits>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"

namespace terravox::bench {
namespace {

using voxel::Box;
using voxel::Material;
using voxel::TreeCell;

void push(std::vector<FoundRun>& runs, int y0, int y1, Material material) {
    if (!runs.empty() && runs.back().y1 == y0 && runs.back().material == material)
        runs.back().y1 = static_cast<std::int16_t>(y1);
    else
        runs.push_back({static_cast<std::int16_t>(y0), static_cast<std::int16_t>(y1), material});
}

// Appends the runs of one column of a box. Air and hidden rock are passed by whole cells of the
// tree.
void read_column(const Box& box, int x, int z, int base_y, std::vector<FoundRun>& runs) {
    const auto cells = box.cells();
    int y = 0;
    while (y < voxel::kBoxSizeY) {
        const TreeCell* cell = &cells[static_cast<std::size_t>(y >> 6)];
        for (int shift = 4;; shift -= 2) {
            const int bit = voxel::child_bit(x >> shift, y >> shift, z >> shift);
            const int end = ((y >> shift) + 1) << shift;
            const bool solid = (cell->mask >> bit & 1) != 0;
            const bool detailed = (cell->detail >> bit & 1) != 0;
            if (solid && detailed && shift > 0) {
                cell = &cells[cell->compute_index(bit)];
                continue;
            }
            if (solid)
                push(runs, base_y + y, base_y + end,
                     detailed ? box.attrs()[cell->compute_index(bit)].material : Material::kRock);
            y = end;
            break;
        }
    }
}

}  // namespace

VoxelField::VoxelField(voxelize::LidarWorld& world, const Area& area, int threads) : m_area(area) {
    if (world.info().voxel_m != 1)
        throw util::Error("compare voxels with columns of 1 m: the world's are " +
                          std::to_string(world.info().voxel_m) + " m");
    m_ground.assign(area.size(), std::numeric_limits<float>::quiet_NaN());
    std::vector<std::vector<FoundRun>> columns(area.size());
    const voxel::VoxelBounds bounds{
        {area.voxel_x(0), world.info().bounds.min[1], area.voxel_z(0)},
        {area.voxel_x(area.width), world.info().bounds.max[1], area.voxel_z(area.height)}};
    const auto range = voxel::boxes_over(bounds, 0);
    const auto across = static_cast<std::size_t>(range.max.bx - range.min.bx);
    const auto count = across * static_cast<std::size_t>(range.max.bz - range.min.bz);
    std::vector<std::vector<TreeTop>> trees(count);
    thread::parallel_for(count, threads, [&](std::size_t i) {
        const std::int32_t bx = range.min.bx + static_cast<std::int32_t>(i % across);
        const std::int32_t bz = range.min.bz + static_cast<std::int32_t>(i / across);
        const auto for_each = [&](const auto& visit) {
            for (int z = 0; z < voxel::kBoxSizeZ; ++z)
                for (int x = 0; x < voxel::kBoxSizeX; ++x) {
                    const int column = bx * voxel::kBoxSizeX + x - area.voxel_x(0);
                    const int row = bz * voxel::kBoxSizeZ + z - area.voxel_z(0);
                    if (area.holds(column, row))
                        visit(x, z, area.index(column, row));
                }
        };
        const auto ground = world.ground_heights(bx, bz);
        for_each([&](int x, int z, std::size_t n) {
            m_ground[n] = ground[static_cast<std::size_t>(z * voxel::kBoxSizeX + x)];
        });
        for (const voxelize::Tree& t : world.trees(bx, bz))
            if (area.holds(t.x - area.voxel_x(0), t.z - area.voxel_z(0)))
                trees[i].push_back({t.x - area.voxel_x(0) + 0.5, t.z - area.voxel_z(0) + 0.5,
                                    static_cast<double>(t.top) - static_cast<double>(t.ground), 0});
        const auto extent = world.column(0, bx, bz);
        for (std::int32_t by = extent.by_begin; by < extent.by_end; ++by) {
            const auto box = world.box({0, bx, by, bz});
            if (box)
                for_each([&](int x, int z, std::size_t n) {
                    read_column(*box, x, z, by * voxel::kBoxSizeY, columns[n]);
                });
        }
    });
    for (const auto& found : trees)
        m_trees.insert(m_trees.end(), found.begin(), found.end());
    join(columns);
}

VoxelField::VoxelField(const Area& area, const std::vector<std::vector<FoundRun>>& runs,
                       std::vector<float> ground_m)
    : m_area(area), m_ground(std::move(ground_m)) {
    join(runs);
}

void VoxelField::join(const std::vector<std::vector<FoundRun>>& columns) {
    m_begin.assign(1, 0);
    m_begin.reserve(columns.size() + 1);
    for (const auto& column : columns)
        m_begin.push_back(m_begin.back() + column.size());
    m_runs.reserve(m_begin.back());
    for (const auto& column : columns)
        m_runs.insert(m_runs.end(), column.begin(), column.end());
}

std::optional<int> VoxelField::ground_top(std::size_t index) const noexcept {
    std::optional<int> top;
    for (const FoundRun& run : runs(index)) {
        if ((top && run.y0 != *top) || voxel::is_plant(run.material) ||
            run.material == Material::kWater)
            break;
        top = run.y1;
    }
    return top;
}

}  // namespace terravox::bench
