#include "voxelserver/make/voxelize/columns/point_set.hpp"

#include <algorithm>

namespace terravox::voxelize {

bool SurveyBounds::surrounds(const grid::ColumnRect& rect) const noexcept {
    return std::any_of(m_files.begin(), m_files.end(), [&](const SquareSource& s) {
        return std::any_of(s.islands.begin(), s.islands.end(), [&](const grid::ColumnRect& island) {
            return rect.min_x >= island.min_x && rect.max_x <= island.max_x &&
                   rect.min_z >= island.min_z && rect.max_z <= island.max_z;
        });
    });
}

Grid<char, Window::kMargin> SurveyBounds::around(grid::PatchKey middle) const {
    using Area = Grid<char, Window::kMargin>;
    Area out(0);
    for (const SquareSource& s : m_files)
        for (const grid::ColumnRect& island : s.islands) {
            const int x0 = std::max(island.min_x - middle.x0(), Area::kFirst);
            const int x1 = std::min(island.max_x - middle.x0(), Area::kLast);
            const int z0 = std::max(island.min_z - middle.z0(), Area::kFirst);
            const int z1 = std::min(island.max_z - middle.z0(), Area::kLast);
            for (int z = z0; z < z1 && x0 < x1; ++z)
                std::fill_n(&out.at(x0, z), x1 - x0, char{1});
        }
    return out;
}

namespace {

Sources timed_sources(const LidarWorldOptions& options, const Settings& settings,
                      util::StageTimes& times) {
    const util::StageTimes::Scope timed(times, "open files");
    return open_sources(options, settings);
}

// At least 2 m, and with enough points that an empty cell is a void, not chance.
int water_cell_voxels(double voxel_m, double density) {
    constexpr double kSmallest_m = 2;
    constexpr double kPointsPerCell = 16;
    int cell = 1;
    while (cell < grid::kPatchSize &&
           (cell * voxel_m < kSmallest_m || density * cell * cell < kPointsPerCell))
        cell *= 2;
    return cell;
}

std::shared_ptr<const PatchColumns> empty_columns(const ClassTable& classes, int cell_voxels) {
    auto out = init_columns({}, classes, cell_voxels);
    for (water::WaterCell& cell : out->cells.cells)
        cell.covered = true;
    return out;
}

}  // namespace

PointSet::PointSet(const LidarWorldOptions& options, const Settings& settings,
                   util::StageTimes& times)
    : m_times(times),
      m_sources(timed_sources(options, settings, times)),
      m_cell_voxels(water_cell_voxels(options.voxel_m, m_sources.density)),
      m_bounds(m_sources.files),
      m_empty(empty_columns(classes(), m_cell_voxels)),
      m_memory(share_memory(options.memory_bytes, m_sources.files)),
      m_report(m_sources.files, classes()),
      m_squares(options, m_sources.files, m_memory, {m_sources.frame, classes(), settings, times},
                m_report),
      m_columns(m_memory.columns) {}

Window PointSet::window(grid::PatchKey middle) {
    Window out;
    out.middle = middle;
    const auto to_key = [&](std::size_t i) {
        return grid::PatchKey{middle.px + static_cast<int>(i % 3) - 1,
                              middle.pz + static_cast<int>(i / 3) - 1};
    };
    // Where parts are decoded, one part serves all that are missing.
    grid::PatchRect missing{{middle.px + 2, middle.pz + 2}, {middle.px - 1, middle.pz - 1}};
    for (std::size_t i = 0; i < out.patches.size(); ++i) {
        const grid::PatchKey key = to_key(i);
        if ((out.patches[i] = m_columns.find(key)))
            continue;
        missing.min = {std::min(missing.min.px, key.px), std::min(missing.min.pz, key.pz)};
        missing.max = {std::max(missing.max.px, key.px + 1), std::max(missing.max.pz, key.pz + 1)};
    }
    Held held;
    for (std::size_t i = 0; i < out.patches.size(); ++i)
        if (!out.patches[i])
            out.patches[i] = columns(to_key(i), missing, held);
    return out;
}

std::shared_ptr<const PatchColumns> PointSet::columns(grid::PatchKey key) {
    Held held;
    return columns(key, {key, {key.px + 1, key.pz + 1}}, held);
}

std::shared_ptr<const PatchColumns> PointSet::columns(grid::PatchKey key,
                                                      const grid::PatchRect& wanted, Held& held) {
    return m_columns.get(
        key, [&] { return make_columns(key, list_points(key, wanted, held)); },
        [this](const auto& p) { return p == m_empty ? std::size_t{0} : p->memory_bytes(); });
}

std::vector<PatchPoints> PointSet::list_points(grid::PatchKey key, const grid::PatchRect& wanted,
                                               Held& held) {
    std::vector<PatchPoints> out;
    // A margin of one voxel: a transformed or rounded point may lie just outside its file's bounds.
    const grid::ColumnRect rect = grid::find_columns(key).grown(1);
    for (std::size_t i = 0; i < m_sources.files.size(); ++i) {
        if (!m_sources.files[i].bounds.overlaps(rect))
            continue;
        Squares& squares = held[i];
        if (squares.empty())
            squares = m_squares.around(i, wanted);
        for (const auto& square : squares)
            if (const auto inside = square->points(key); !inside.empty())
                out.push_back({inside, m_sources.files[i].has_colour});
    }
    return out;
}

std::shared_ptr<const PatchColumns> PointSet::make_columns(
    grid::PatchKey key, const std::vector<PatchPoints>& points) const {
    const util::StageTimes::Scope timed(m_times, "column init");
    // Wide empty extents (a stray header, the sea) share one patch.
    if (points.empty() && m_bounds.surrounds(grid::find_columns(key)))
        return m_empty;
    auto out = init_columns(points, classes(), m_cell_voxels);
    mark_covered(key, out->cells);
    return out;
}

void PointSet::mark_covered(grid::PatchKey key, water::CellPatch& cells) const noexcept {
    for (int z = 0; z < cells.side; ++z)
        for (int x = 0; x < cells.side; ++x)
            cells.cells[static_cast<std::size_t>(z * cells.side + x)].covered =
                m_bounds.contains(key.x0() + x * m_cell_voxels + m_cell_voxels / 2,
                                  key.z0() + z * m_cell_voxels + m_cell_voxels / 2);
}

}  // namespace terravox::voxelize
