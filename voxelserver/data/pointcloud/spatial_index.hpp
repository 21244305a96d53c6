#pragma once

#include <string>
#include <utility>
#include <vector>

#include "voxelserver/data/pointcloud/point.hpp"

namespace terravox::pointcloud {

/// A spatial index of the points of a file. Immutable, so it may be shared between threads.
class SpatialIndex {
public:
    /// A closed rectangle in file coordinates, and points that lie in it. The rectangle may be
    /// infinite.
    struct Cell {
        double min_x = 0;
        double min_y = 0;
        double max_x = 0;
        double max_y = 0;
        PointRange points;
    };
    /// @param source  the index's origin, for messages
    /// @param chunks  whether each cell is one chunk of the file
    SpatialIndex(std::vector<Cell> cells, std::string source, bool chunks)
        : m_cells(std::move(cells)), m_source(std::move(source)), m_chunks(chunks) {}

    /// Ranges of points (sorted, merged, half-open) that contain every point inside the closed
    /// rectangle in file coordinates; they may contain others. Linear in the number of cells, some
    /// thousand for a square.
    [[nodiscard]] std::vector<PointRange> ranges_over(double min_x, double min_y, double max_x,
                                                      double max_y) const;
    /// Whether its cells correspond one to one to the file's chunks, as in COPC.
    [[nodiscard]] bool by_chunk() const noexcept { return m_chunks; }
    /// The same ranges, sorted, but not merged: one per cell.
    [[nodiscard]] std::vector<PointRange> cells_over(double min_x, double min_y, double max_x,
                                                     double max_y) const;
    [[nodiscard]] const std::string& source() const noexcept { return m_source; }

private:
    std::vector<Cell> m_cells;
    std::string m_source;
    bool m_chunks;
};

}  // namespace terravox::pointcloud
