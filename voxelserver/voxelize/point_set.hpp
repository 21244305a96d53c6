#pragma once

#include <memory>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/stage_times.hpp"
#include "voxelserver/voxelize/columns.hpp"
#include "voxelserver/voxelize/lidar_world.hpp"
#include "voxelserver/voxelize/terrain_grid.hpp"
#include "voxelserver/voxelize/window.hpp"

namespace terravox::voxelize {

/// All squares of a world: which there are, and their points patch by patch, decoded when needed and kept under a byte limit.
/// Thread-safe once made.
class PointSet {
public:
    /// Reads all headers. @throws UsageError, Error
    PointSet(const LidarWorldOptions& options, util::StageTimes& times);

    [[nodiscard]] const Frame& frame() const noexcept { return *m_frame; }
    [[nodiscard]] const ClassTable& classes() const noexcept { return m_classes; }
    [[nodiscard]] Base base() const noexcept { return m_base; }
    [[nodiscard]] std::size_t file_count() const noexcept { return m_sources.size(); }
    [[nodiscard]] std::uint64_t point_count() const noexcept { return m_point_count; }
    [[nodiscard]] std::uint64_t wild_points() const noexcept { return m_wild_points; }
    /// Horizontal bounds of all files' headers, voxels relative to the base, half-open.
    struct Bounds { std::int32_t min_x, min_z, max_x, max_z; };
    [[nodiscard]] const Bounds& bounds() const noexcept { return m_bounds; }
    /// Which columns of a patch and its margin lie inside some file's bounds. @param x0, z0 voxels relative to the base
    [[nodiscard]] Margined<char> surveyed(std::int32_t x0, std::int32_t z0) const;

    /// Decodes every square once, in order, for the coarse terrain.
    [[nodiscard]] TerrainGrid scan_terrain();

    /// The columns of a patch (key in patches of 64, relative to the base). Never nullptr.
    [[nodiscard]] std::shared_ptr<const PatchColumns> columns(PatchKey key);

private:
    struct Entry {
        SquareSource source;
        Bounds bounds;
    };
    [[nodiscard]] std::shared_ptr<const Square> square(std::size_t index, int threads);

    util::StageTimes& m_times;
    ClassTable m_classes;
    std::unique_ptr<Frame> m_frame;
    std::vector<Entry> m_sources;
    Base m_base;
    Bounds m_bounds{};
    std::uint64_t m_point_count = 0, m_wild_points = 0;
    int m_threads;
    util::Cache<std::size_t, Square> m_squares;
    util::Cache<PatchKey, PatchColumns, PatchKeyHash> m_columns;
};

}  // namespace terravox::voxelize
