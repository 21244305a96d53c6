#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "common/util/cache.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/serve/map/column_top.hpp"

namespace terravox::map {

/// One box column from above, as far as it is known.
struct Top {
    std::shared_ptr<const BoxTop> top;  ///< nullptr: the column is empty, or unknown
    bool known = false;        ///< false: not made yet; only possible when `make` was false
    voxel::InputExtent reach;  ///< reach of its boxes; empty = the box column alone
};

/// A square of the map's finest tiles, each 4 x 4 box columns (256 x 256 columns): 2^zooms_out
/// tiles per side, the first one at (x, z) * 2^zooms_out.
struct TileArea {
    int zooms_out = 0;
    std::int32_t x = 0;
    std::int32_t z = 0;
    friend bool operator==(const TileArea&, const TileArea&) = default;
};
inline constexpr int kTileBoxes = 4;  ///< box columns per side of a finest tile

/// Provides box columns to the map. Thread-safe; a column never changes once it is known.
class TopSource {
public:
    TopSource() = default;
    TopSource(const TopSource&) = delete;
    TopSource& operator=(const TopSource&) = delete;
    virtual ~TopSource() = default;

    /// @param make false: return only what is available, without delay
    /// @throws Error when the column cannot be made
    [[nodiscard]] virtual Top top(std::int32_t bx, std::int32_t bz, bool make) = 0;

    /// A number that increases whenever a column of the area, or of the ring of box columns around
    /// it, becomes available; 0: none has yet. Fast.
    [[nodiscard]] virtual std::uint64_t version(const TileArea& area) = 0;
};

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

/// The boxes of level 0 of one box column, and the extent of their inputs.
struct ColumnBoxes {
    std::vector<std::shared_ptr<const voxel::Box>> boxes;  ///< nullptr: air
    voxel::InputExtent reach;                              ///< empty = the box column alone
};
/// Fetches a column; called from any thread. With make = false it returns nullopt when not all
/// boxes of the column are available.
/// @throws Error when they cannot be made
using FetchColumn =
    std::function<std::optional<ColumnBoxes>(std::int32_t bx, std::int32_t bz, bool make)>;

/// Box columns seen from above, cached under a byte limit (32 KiB each); their boxes are made and
/// cached elsewhere. Thread-safe.
class TopCache final : public TopSource {
public:
    /// @param zooms zooms of the map = levels of the world
    TopCache(FetchColumn fetch, TopColours colours, int zooms, std::size_t limit_bytes);

    [[nodiscard]] Top top(std::int32_t bx, std::int32_t bz, bool make) override;
    [[nodiscard]] std::uint64_t version(const TileArea& area) override {
        return m_made.version(area);
    }

    /// Must be called when all boxes of a column have become available by other means than top(),
    /// and only after `fetch` can find them: the map may show them from now on. Cheap enough to
    /// call for every column.
    void note_made(std::int32_t bx, std::int32_t bz) { m_made.add(bx, bz); }

    [[nodiscard]] util::CacheStats stats() const { return m_tops.stats(); }

private:
    struct Place {
        std::int32_t bx;
        std::int32_t bz;
        friend bool operator==(const Place&, const Place&) = default;
    };
    struct PlaceHash {
        [[nodiscard]] std::size_t operator()(const Place& place) const noexcept;
    };
    struct Kept {
        std::shared_ptr<const BoxTop> top;
        voxel::InputExtent reach;
    };
    [[nodiscard]] std::shared_ptr<const Kept> find_kept(const ColumnBoxes& column) const;

    const FetchColumn m_fetch;
    const TopColours m_colours;
    MadeAreas m_made;
    util::Cache<Place, Kept, PlaceHash> m_tops;
};

}  // namespace terravox::map
