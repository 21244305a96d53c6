#pragma once

#include <memory>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/material.hpp"
#include "voxelserver/make/voxelize/world/lidar_world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/out/country/workload.hpp"
#include "voxelserver/out/export/core/job.hpp"
#include "voxelserver/out/export/core/part.hpp"

namespace terravox::country {

/// The world of a plan, and the part of it that is made.
class OpenedCountry {
public:
    /// @param part of level 0
    /// @throws UsageError, Error as voxelize::open_lidar_world() and exports::part_of()
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
