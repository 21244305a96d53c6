#pragma once

#include <cstdint>
#include <mutex>
#include <unordered_map>

#include "voxelserver/serve/map/top_source.hpp"

namespace terravox::map {

/// Tracks the areas in which anything has been made, so that a map of a large world need not query
/// every box column: a quadtree of counters over the map's finest tiles. Holds at most a third more
/// entries than finest tiles that were ever touched (about 60 bytes each). Thread-safe.
class MadeAreas {
public:
    /// @param zooms zooms of the map; areas with zooms_out in [0, zooms) can be queried
    explicit MadeAreas(int zooms) : m_zooms(zooms) {}

    /// Records that a box column has become available: all tiles that show it, or whose shading
    /// depends on it, change.
    void add(std::int32_t bx, std::int32_t bz);
    /// As TopSource::version.
    [[nodiscard]] std::uint64_t version(const TileArea& area) const;

private:
    struct AreaHash {
        [[nodiscard]] std::size_t operator()(const TileArea& area) const noexcept;
    };
    const int m_zooms;
    mutable std::mutex m_mutex;
    /// The value of m_clock when the area last changed.
    std::unordered_map<TileArea, std::uint64_t, AreaHash> m_versions;
    std::uint64_t m_clock = 0;
};

}  // namespace terravox::map
