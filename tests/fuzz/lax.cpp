// An index next to a point cloud (.lax): the input is the index, the point cloud is a good one.
#include <fstream>

#include "tests/fuzz/fuzz.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "voxelserver/data/lidar/spatial_index.hpp"

namespace terravox::fuzz {

void run(Input input) {
    const auto index_file = as_file(input, "points.lax");
    static const lidar::LasInfo info = [&] {
        const auto file = index_file.parent_path() / "points.laz";
        test::write_sample(file, 3, 500);
        return lidar::read_las_info(file);
    }();
    const auto index = lidar::read_spatial_index(info);
    if (!index)
        return;
    const auto all = index->ranges_over(-1e300, -1e300, 1e300, 1e300);
    expect(all.size() == 1 && all[0].begin == 0 && all[0].end == info.point_count,
           "an index holds every point");
}

}  // namespace terravox::fuzz
