#pragma once

#include <string>
#include <utility>
#include <vector>

#include "voxelserver/pointcloud/point.hpp"

namespace terravox::pointcloud {

/// Which points of a file lie where. Immutable: share it between threads.
class SpatialIndex {
public:
    /// A closed rectangle in file coordinates, and points that lie in it. May be infinite.
    struct Cell {
        double min_x = 0, min_y = 0, max_x = 0, max_y = 0;
        PointRange points;
    };
    /// @param source  what it was read from, for messages
    /// @param chunks  whether each cell is one chunk of the file
    SpatialIndex(std::vector<Cell> cells, std::string source, bool chunks)
        : m_cells(std::move(cells)), m_source(std::move(source)), m_chunks(chunks) {}

    /// Ranges of points (sorted, merged, half-open) that hold every point inside the closed
    /// rectangle in file coordinates; may hold others. Time grows with the number of cells, some
    /// thousand for a square.
    [[nodiscard]] std::vector<PointRange> ranges_over(double min_x, double min_y, double max_x,
                                                      double max_y) const;
    /// Whether its cells are the file's chunks, one by one, as in COPC.
    [[nodiscard]] bool by_chunk() const noexcept { return m_chunks; }
    /// The same ranges, sorted, but those of each cell by itself.
    [[nodiscard]] std::vector<PointRange> cells_over(double min_x, double min_y, double max_x,
                                                     double max_y) const;
    [[nodiscard]] const std::string& source() const noexcept { return m_source; }

private:
    std::vector<Cell> m_cells;
    std::string m_source;
    bool m_chunks;
};

}  // namespace terravox::pointcloud
