#include "voxelserver/data/pointcloud/point_source.hpp"

#include <algorithm>

namespace terravox::pointcloud {

std::vector<PointRange> SpatialIndex::cells_over(double min_x, double min_y, double max_x,
                                                 double max_y) const {
    std::vector<PointRange> out;
    for (const Cell& cell : m_cells)
        if (cell.min_x <= max_x && min_x <= cell.max_x && cell.min_y <= max_y &&
            min_y <= cell.max_y)
            out.push_back(cell.points);
    std::sort(out.begin(), out.end(),
              [](const PointRange& a, const PointRange& b) { return a.begin < b.begin; });
    return out;
}

std::vector<PointRange> SpatialIndex::ranges_over(double min_x, double min_y, double max_x,
                                                  double max_y) const {
    std::vector<PointRange> out;
    for (const PointRange& range : cells_over(min_x, min_y, max_x, max_y)) {
        if (!out.empty() && range.begin <= out.back().end)
            out.back().end = std::max(out.back().end, range.end);
        else
            out.push_back(range);
    }
    return out;
}

}  // namespace terravox::pointcloud
