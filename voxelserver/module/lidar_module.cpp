#include "voxelserver/module/lidar_module.hpp"

#include <string>

#include "common/geo/gdal.hpp"
#include "common/util/error.hpp"
#include "common/util/version.hpp"

extern "C" terravox::module::OpenLidarWorld terravox_open_lidar_world;

terravox::voxelize::LidarWorld* terravox_open_lidar_world(
    const char* version, const terravox::voxelize::LidarWorldOptions& options,
    terravox::util::StageTimes& times, std::int64_t image_bytes) {
    using namespace terravox;
    if (std::string(version) != kVersion)
        throw Error(std::string("use the LiDAR module: it is of version ") + kVersion +
                    "; allowed: that of the program, " + version);
    geo::limit_gdal_cache(image_bytes);
    return voxelize::open_lidar_world(options, times).release();
}
