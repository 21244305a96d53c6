#include "voxelserver/data/lidar/las_source.hpp"

namespace terravox::lidar {

pointcloud::Recognition LasFormat::recognise(std::string_view head) noexcept {
    return head.starts_with("LASF") ? pointcloud::Recognition::kPoints
                                    : pointcloud::Recognition::kUnknown;
}

}  // namespace terravox::lidar
