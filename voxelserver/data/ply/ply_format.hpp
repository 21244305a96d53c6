#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string_view>

#include "voxelserver/data/pointcloud/point_format.hpp"

namespace terravox::ply {

/// The entry of PLY in the list of point formats (pointcloud/point_format.hpp).
struct PlyFormat {
    static constexpr std::string_view kName = "PLY";
    static constexpr std::array<std::string_view, 1> kEndings{".ply"};
    static constexpr std::string_view kSideEnding = ".prj";
    /// @return kOther for a file with faces: a mesh, like those that the exporters write
    [[nodiscard]] static pointcloud::Recognition recognise(std::string_view head) noexcept;
    [[nodiscard]] static std::unique_ptr<const pointcloud::PointSource> open(
        const std::filesystem::path& path);
};

}  // namespace terravox::ply
