#pragma once

#include <span>

#include "voxelserver/data/lidar/las_file.hpp"

namespace terravox::lidar {

/// read_point_batches() for one range, point by point in file coordinates.
template <class Use>
void read_las_points(const LasInfo& info, PointRange range, const Use& use) {
    pointcloud::Point point;
    read_point_batches(info, {&range, 1}, [&](std::span<const RawPoint> batch) {
        for (const RawPoint& raw : batch) {
            point.x = raw.x * info.scale[0] + info.offset[0];
            point.y = raw.y * info.scale[1] + info.offset[1];
            point.z = raw.z * info.scale[2] + info.offset[2];
            point.classification = raw.classification;
            point.return_number = raw.return_number;
            point.return_count = raw.return_count;
            point.intensity = raw.intensity;
            point.line = raw.point_source;
            point.withheld = raw.withheld;
            point.overlap = raw.overlap;
            point.rgb = raw.rgb;
            use(point);
        }
    });
}

}  // namespace terravox::lidar
