#include "voxelserver/voxelize/input_files.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "common/util/files.hpp"

namespace terravox::voxelize {

std::vector<std::filesystem::path> lidar_files(const LidarWorldOptions& options) {
    if (options.files.empty())
        throw UsageError("open the LiDAR data: no file or folder given");
    auto files = util::expand_folders(options.files, {".las", ".laz"}, "LiDAR data");
    std::sort(files.begin(), files.end());
    return files;
}

std::vector<std::filesystem::path> orthophoto_files(
    const std::vector<std::filesystem::path>& paths) {
    return util::expand_folders(paths, {".tif", ".tiff", ".vrt", ".jp2", ".jpg", ".jpeg", ".png"},
                                "orthophotos");
}

}  // namespace terravox::voxelize
