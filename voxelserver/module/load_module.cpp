#include "voxelserver/module/load_module.hpp"

#include <dlfcn.h>

#include "common/util/beside_program.hpp"
#include "common/util/error.hpp"
#include "common/util/version.hpp"
#include "voxelserver/module/lidar_module.hpp"

namespace terravox::module {

std::filesystem::path lidar_module() {
    return util::beside_program(TERRAVOX_LIDAR_MODULE);
}

std::unique_ptr<voxelize::LidarWorld> open_lidar_world(const voxelize::LidarWorldOptions& options,
                                                       util::StageTimes& times,
                                                       std::size_t image_bytes) {
    void* library = util::open_beside_program(TERRAVOX_LIDAR_MODULE, "LiDAR module");
    auto* open = reinterpret_cast<OpenLidarWorld*>(dlsym(library, kOpenLidarWorld));
    if (open == nullptr)
        throw Error("load the LiDAR module " + lidar_module().string() + ": it has no " +
                    kOpenLidarWorld);
    return std::unique_ptr<voxelize::LidarWorld>(
        open(kVersion, options, times, static_cast<std::int64_t>(image_bytes)));
}

}  // namespace terravox::module
