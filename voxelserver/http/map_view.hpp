#pragma once

#include <atomic>
#include <optional>
#include <thread>

#include "voxelserver/boxes/box_cache.hpp"
#include "voxelserver/map/map_tiles.hpp"
#include "voxelserver/map/top_cache.hpp"

namespace terravox::http {

/// The world from above, made of the boxes that a cache keeps and makes. Complete tiles are kept on
/// disk beside the boxes, where there is a disk cache. Thread-safe.
class MapView {
public:
    /// Listens to the cache, which must outlive this; to be made before anyone asks the cache.
    /// @param colours of the materials @param memory_bytes for tops and tiles
    MapView(boxes::BoxCache& cache, map::TopColours colours, std::size_t memory_bytes);
    ~MapView();  ///< closes the cache
    /// Begins to look on a thread of its own for what earlier processes have left on disk; until
    /// that is done, overviews show what has come to hand since. To be called once, when the server
    /// answers: it takes time from nobody who waits for the start.
    void look_through_disk();
    MapView(const MapView&) = delete;
    MapView& operator=(const MapView&) = delete;

    /// @throws UsageError for a zoom that the map has not; boxes::OverloadedError; Error
    [[nodiscard]] map::Tile get(int z, std::int32_t x, std::int32_t y);

    /// The tile that shows nothing.
    [[nodiscard]] static const std::shared_ptr<const std::string>& empty_tile();

private:
    [[nodiscard]] std::optional<map::ColumnBoxes> fetch(std::int32_t bx, std::int32_t bz,
                                                        bool make);
    void note(const voxel::BoxKey& key);
    void note_kept();

    boxes::BoxCache& m_cache;
    const std::uint64_t
        m_look;  ///< stands for colours and ways of drawing: tiles of another look are not used
    map::TopCache m_tops;
    map::MapTiles m_tiles;
    std::atomic<bool> m_stop{false};
    std::thread m_looking;  ///< tells the map which columns earlier processes have left on disk
};

}  // namespace terravox::http
