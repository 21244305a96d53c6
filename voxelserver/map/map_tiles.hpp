#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/util/cache.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/map/hill_shade.hpp"
#include "voxelserver/map/top_source.hpp"

namespace terravox::map {

inline constexpr int kTilePx = 256;

struct Tile {
    std::shared_ptr<const std::string>
        png;  ///< nullptr: nothing to be seen in it (all transparent)
    bool complete =
        false;  ///< false: some of it has not been made yet; it may look different later
    voxel::InputExtent
        reach;  ///< box columns it was made of, of what was at hand; empty outside the world
};

/// The world from above as tiles of 256 x 256 pixels. At the finest zoom, levels - 1, a pixel is a
/// column; each zoom below shows twice as many. Tile (x, y) covers columns from 256 x and 256 y (in
/// pixels of its zoom), to the east and to the south; both may be negative.
///
/// At the three finest zooms missing box columns are made (at most 18 x 18); below, only what is at
/// hand is shown. Finest tiles are shaded; the others are means of four, in linear light, weighted
/// by alpha. The same columns give the same bytes, whatever was asked before.
///
/// Thread-safe. Pictures are kept in two caches (pixels and PNG), each value made by nobody's lock;
/// whoever wants a tile of the finest three zooms that another thread makes waits for it. Threads
/// wait only for finer zooms than their own, so they cannot wait in a circle. A complete tile
/// stays. An incomplete one is kept under the version of its area (TopSource::version) and made
/// again when that has grown: of an overview only the parts that changed. One call makes at most
/// kMaxTiles pictures; what is left shows as not made, and the next call goes on from there.
class MapTiles {
public:
    static constexpr int kZoomsMade = 3;   ///< zooms at which what is missing is made
    static constexpr int kMaxTiles = 160;  ///< pictures of all zooms made in one call

    /// @param source must outlive this @param limit_bytes of both caches; a finest tile weighs 256
    /// KiB and its PNG about 100
    MapTiles(const voxel::WorldInfo& info, TopSource& source, std::size_t limit_bytes);

    [[nodiscard]] int zooms() const noexcept { return m_zooms; }  ///< z in [0, zooms())

    /// Any x and y will do: outside the world a tile is empty and complete.
    /// @throws UsageError for a zoom that is none; Error when a box column that it needs cannot be
    /// made
    [[nodiscard]] Tile get(int z, std::int32_t x, std::int32_t y);

    [[nodiscard]] util::CacheStats pixel_stats() const { return m_pixels.stats(); }
    [[nodiscard]] util::CacheStats png_stats() const { return m_pngs.stats(); }

private:
    struct Key {
        TileArea area;
        std::uint64_t version =
            0;  ///< of the area when the picture was begun; kWhole or kSeenWhole for complete ones
        friend bool operator==(const Key&, const Key&) = default;
    };
    struct KeyHash {
        [[nodiscard]] std::size_t operator()(const Key& key) const noexcept;
    };
    struct Picture {
        std::vector<Rgba8> pixels;  ///< 256 x 256, row by row; none: all transparent
        bool complete = true;
        bool cut = false;  ///< the call's share of work was spent: not to be kept
        voxel::InputExtent reach;
    };
    using PicturePtr = std::shared_ptr<const Picture>;
    struct Work {
        bool make = false;
        int tiles_left = kMaxTiles;
    };
    // Versions of complete pictures, which stay right for good. Those made of what was at hand have
    // their own, so that whoever looks only at that never waits in the cache for one who makes the
    // same picture.
    static constexpr std::uint64_t kWhole = ~std::uint64_t{0}, kSeenWhole = kWhole - 1;

    [[nodiscard]] bool in_world(int zooms_out, std::int64_t x, std::int64_t z) const noexcept;
    [[nodiscard]] PicturePtr picture(const TileArea& area, Work& work);
    [[nodiscard]] PicturePtr compose(const TileArea& area, Work& work);
    [[nodiscard]] PicturePtr finest(const TileArea& area, const Work& work);
    [[nodiscard]] PicturePtr mean_of_four(const TileArea& area, Work& work);
    [[nodiscard]] std::shared_ptr<const std::string> png(const TileArea& area,
                                                         const Picture& picture,
                                                         std::uint64_t version);

    const int m_zooms;
    const voxel::InputExtent m_world;  ///< box columns within the world's bounds
    TopSource& m_source;
    util::Cache<Key, Picture, KeyHash> m_pixels;
    util::Cache<Key, std::string, KeyHash> m_pngs;
};

}  // namespace terravox::map
