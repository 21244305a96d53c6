#include "voxelserver/make/voxelize/points/lidar_files.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "voxelserver/data/pointcloud/formats/files.hpp"

namespace terravox::voxelize {

std::vector<std::filesystem::path> lidar_files(const LidarWorldOptions& options) {
    if (options.files.empty())
        throw util::UsageError("open the LiDAR data: no file or folder given");
    auto files = pointcloud::expand_point_files(options.files);
    std::sort(files.begin(), files.end());
    std::erase_if(files, [&](const std::filesystem::path& file) {
        return std::find(options.left_out.begin(), options.left_out.end(), file) !=
               options.left_out.end();
    });
    if (files.empty())
        throw util::UsageError("open the LiDAR data: all files are left out");
    return files;
}

}  // namespace terravox::voxelize
