#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/material.hpp"
#include "voxelserver/data/grid/patch.hpp"
#include "voxelserver/make/voxelize/world/lidar_world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/out/export/core/columns.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::country {

/// A square, as far as the work for it depends on it.
struct SurveySquare {
    grid::ColumnRect bounds;
    std::uint64_t points = 0;
    /// What it takes decoded, on disk.
    [[nodiscard]] std::uint64_t scratch_bytes() const noexcept { return points * kPoint_bytes; }
    static constexpr std::uint64_t kPoint_bytes = 12;  ///< docs/formats/cache-folder.md
};

/// The squares of a survey by place. Immutable.
class Survey {
public:
    /// A box column reads the patch of 64 voxels around it.
    static constexpr std::int32_t kHalo_voxels = grid::kPatchSize;

    /// @param edge of a column of boxes, voxels
    Survey(std::vector<SurveySquare> squares, std::int32_t edge);

    [[nodiscard]] const std::vector<SurveySquare>& squares() const noexcept { return m_squares; }
    /// The squares that a column of boxes reads, by number, ascending.
    [[nodiscard]] std::vector<std::size_t> read_by(const exports::Columns::At& column) const;
    /// Number of columns of voxels of a column of boxes that lie in squares, at most all.
    [[nodiscard]] double covered(const exports::Columns::At& column) const;

private:
    [[nodiscard]] grid::ColumnRect to_rect(const exports::Columns::At& column) const noexcept;

    std::vector<SurveySquare> m_squares;
    std::int32_t m_edge;
    /// Numbers of squares that a column of boxes reads, by its place.
    std::unordered_map<std::uint64_t, std::vector<std::size_t>> m_read_by;
};

/// What some columns of boxes take, made one after the other with a folder for decoded squares.
struct Workload {
    std::uint64_t columns = 0;
    double covered = 0;         ///< columns of voxels that lie in squares
    std::uint64_t squares = 0;  ///< that are decoded; one that was dropped counts again
    double points = 0;          ///< that are decoded
    std::uint64_t scratch_bytes = 0;
};
/// @param first, end of the columns that are made
/// @param scratch_bytes limit of the folder: the squares used longest ago are dropped
[[nodiscard]] Workload measure_workload(const Survey& survey, const exports::Columns& columns,
                                        std::size_t first, std::size_t end,
                                        std::uint64_t scratch_bytes);

/// The world of a plan, and the part of it that is made.
class OpenedCountry {
public:
    /// @param part of level 0
    /// @throws UsageError, Error as voxelize::open_lidar_world() and exports::make_part()
    OpenedCountry(const worlds::WorldOptions& options, const exports::Selection& part);

    [[nodiscard]] voxelize::LidarWorld& world() noexcept { return *m_world; }
    [[nodiscard]] const exports::Part& part() const noexcept { return m_part; }
    [[nodiscard]] const voxel::Palette& palette() const noexcept { return m_palette; }
    /// Of all inputs and settings, 32 hexadecimal digits.
    [[nodiscard]] std::string fingerprint() const;
    /// Of what each box depends on, wherever it lies: settings, class table and palette, the CRS,
    /// and the lowest place of all. 32 hexadecimal digits.
    [[nodiscard]] std::string fingerprint_of_all_boxes() const;
    /// Its squares, in the order of LidarWorld::squares().
    [[nodiscard]] std::vector<SurveySquare> squares() const;

private:
    util::StageTimes m_times;
    std::unique_ptr<voxelize::LidarWorld> m_world;
    exports::Part m_part;
    voxel::Palette m_palette;  ///< an archive holds materials, not their colours
};

}  // namespace terravox::country
