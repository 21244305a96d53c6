#include "voxelserver/make/voxelize/points/options.hpp"

#include <algorithm>
#include <filesystem>

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

namespace {

namespace fs = std::filesystem;

/// The path without "." and "..", and without a slash at its end.
fs::path whole(const fs::path& path) {
    std::error_code failed;
    const fs::path out = fs::absolute(path, failed).lexically_normal();
    return out.has_filename() ? out : out.parent_path();
}

std::string to_name(const fs::path& input) {
    std::error_code failed;
    const fs::path path = whole(input);
    return (fs::is_directory(path, failed) ? path.filename() : path.stem()).string();
}

}  // namespace

std::string world_title(const LidarWorldOptions& options) {
    if (!options.title.empty())
        return options.title;
    const std::vector<fs::path>& inputs = options.files;
    if (inputs.size() == 1)
        return to_name(inputs.front());
    const fs::path folder = whole(inputs.front()).parent_path();
    const bool is_shared = std::all_of(inputs.begin(), inputs.end(), [&](const fs::path& input) {
        return whole(input).parent_path() == folder;
    });
    if (is_shared && folder.has_filename())
        return folder.filename().string();
    return to_name(inputs.front()) + " and " + std::to_string(inputs.size() - 1) + " more";
}

}  // namespace terravox::voxelize
