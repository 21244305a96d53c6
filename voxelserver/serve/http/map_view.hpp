#pragma once

#include <atomic>
#include <optional>
#include <thread>

#include "voxelserver/serve/boxes/box_cache.hpp"
#include "voxelserver/serve/map/map_tiles.hpp"
#include "voxelserver/serve/map/top_cache.hpp"

namespace terravox::http {

/// The world from above, drawn from the boxes of a cache. Complete tiles are cached on disk along
/// with the boxes, where there is a disk cache. Thread-safe.
class MapView {
public:
    /// Registers itself as the listener of the cache, which must outlive this; must be constructed
    /// before the first request to the cache.
    /// @param colours colours of the materials
    /// @param memory_bytes memory limit for tops and tiles
    MapView(boxes::BoxCache& cache, map::TopColours colours, std::size_t memory_bytes);
    ~MapView();  ///< closes the cache
    /// Starts a thread that searches the disk cache for boxes left by earlier processes; until it
    /// has finished, overviews show only boxes that have become available since. Must be called
    /// once, when the server is responding, so that it does not delay the start.
    void scan_disk();
    MapView(const MapView&) = delete;
    MapView& operator=(const MapView&) = delete;

    /// @throws UsageError for a zoom that the map does not have; boxes::OverloadedError; Error
    [[nodiscard]] map::Tile get(int z, std::int32_t x, std::int32_t y);

    /// The tile for an empty area.
    [[nodiscard]] static const std::shared_ptr<const std::string>& empty_tile();

private:
    [[nodiscard]] std::optional<map::ColumnBoxes> fetch(std::int32_t bx, std::int32_t bz,
                                                        bool make);
    void note(const voxel::BoxKey& key);
    void note_boxes_on_disk();

    boxes::BoxCache& m_cache;
    /// A hash of the colours and the drawing method: tiles with another hash are not used.
    const std::uint64_t m_look;
    map::TopCache m_tops;
    map::MapTiles m_tiles;
    std::atomic<bool> m_stop{false};
    std::thread m_scan_thread;  ///< registers the columns that earlier processes have left on disk
};

}  // namespace terravox::http
