#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string_view>

#include "voxelserver/data/pointcloud/point_format.hpp"

namespace terravox::lidar {

/// The entry of LAS, LAZ and COPC in the list of point formats (pointcloud/point_format.hpp).
struct LasFormat {
    static constexpr std::string_view kName = "LAS, LAZ or COPC";
    static constexpr std::array<std::string_view, 2> kEndings{".las", ".laz"};
    static constexpr std::string_view kSideEnding{};  ///< none: an index does not affect voxels
    [[nodiscard]] static pointcloud::Recognition recognise(std::string_view head) noexcept;
    [[nodiscard]] static std::unique_ptr<const pointcloud::PointSource> open(
        const std::filesystem::path& path);
};

}  // namespace terravox::lidar
