#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/util/cache.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/serve/map/pixels.hpp"
#include "voxelserver/serve/map/top_cache.hpp"

namespace terravox::map {

/// The shaded image of kTileBoxes x kTileBoxes box columns.
struct FinestTile {
    /// 256 x 256, row by row from the north-west; empty: there is nothing.
    std::vector<Rgba8> pixels;
    bool complete = true;      ///< whether all box columns that it depends on were known
    voxel::InputExtent reach;  ///< reach of those box columns
};

/// Makes a tile from its box columns and, where the tile's edge is not empty, from those of the
/// ring around it, which shading needs.
/// @param x, z the tile's first box column is (x, z) * kTileBoxes
/// @param world box columns that may contain anything; others are not requested
/// @throws what the source throws
[[nodiscard]] FinestTile make_finest_tile(TopSource& source, const voxel::InputExtent& world,
                                          std::int32_t x, std::int32_t z, bool make);

inline constexpr int kTilePx = 256;

struct Tile {
    /// nullptr: the tile is empty (all transparent).
    std::shared_ptr<const std::string> png;
    /// False: some of it has not been made yet, and it may look different later.
    bool complete = false;
    /// The box columns that it was made from, as far as they were available; empty outside the
    /// world.
    voxel::InputExtent reach;
};

/// The world from above as tiles of 256 x 256 pixels. At the finest zoom, levels - 1, a pixel is a
/// column; each coarser zoom doubles the number of columns per pixel edge. Tile (x, y) covers
/// columns from 256 x and 256 y (in pixels of its zoom), to the east and to the south; both may be
/// negative.
///
/// At the three finest zooms missing box columns are made (at most 18 x 18); at coarser ones, only
/// available ones are shown. Tiles of the finest zoom are shaded; the others are means of four
/// pixels, in linear light, weighted by alpha. The same columns give the same bytes, regardless of
/// earlier requests.
///
/// Thread-safe. Pictures are kept in two caches (pixels and PNG) and made without holding a lock; a
/// request for a tile of the three finest zooms that another thread is making waits for it. Threads
/// wait only for finer zooms than their own, so there is no deadlock. A complete tile stays valid.
/// An incomplete one is cached under the version of its area (TopSource::version) and made again
/// when that has increased: of an overview only the parts that changed. One call makes at most
/// kMaxTiles pictures; the rest is shown as not made, and the next call continues from there.
class MapTiles {
public:
    static constexpr int kZoomsMade = 3;  ///< zooms at which missing box columns are made
    /// Maximum number of pictures, of all zooms, made in one call.
    static constexpr int kMaxTiles = 160;

    /// @param source must outlive this
    /// @param limit_bytes of both caches; a finest tile takes 256 KiB and its PNG about 100
    MapTiles(const voxel::WorldInfo& info, TopSource& source, std::size_t limit_bytes);

    [[nodiscard]] int zooms() const noexcept { return m_zooms; }  ///< z in [0, zooms())

    /// Any x and y are valid: outside the world a tile is empty and complete.
    /// @throws UsageError for an invalid zoom; Error when a required box column cannot be made
    [[nodiscard]] Tile get(int z, std::int32_t x, std::int32_t y);

    [[nodiscard]] util::CacheStats pixel_stats() const { return m_pixels.stats(); }
    [[nodiscard]] util::CacheStats png_stats() const { return m_pngs.stats(); }

private:
    struct Key {
        TileArea area;
        /// Version of the area when the picture was begun; kWhole or kSeenWhole for complete ones.
        std::uint64_t version = 0;
        friend bool operator==(const Key&, const Key&) = default;
    };
    struct KeyHash {
        [[nodiscard]] std::size_t operator()(const Key& key) const noexcept;
    };
    struct Picture {
        std::vector<Rgba8> pixels;  ///< 256 x 256, row by row; empty: all transparent
        bool complete = true;
        bool cut = false;  ///< the call's limit of work was reached: must not be cached
        voxel::InputExtent reach;
    };
    using PicturePtr = std::shared_ptr<const Picture>;
    struct Work {
        bool make = false;
        int tiles_left = kMaxTiles;
    };
    // Versions of complete pictures, which stay valid. Pictures made only from available
    // columns have a version of their own, so that a request that makes nothing never waits in the
    // cache for one that makes the same picture.
    static constexpr std::uint64_t kWhole = ~std::uint64_t{0};
    static constexpr std::uint64_t kSeenWhole = kWhole - 1;

    [[nodiscard]] bool in_world(int zooms_out, std::int64_t x, std::int64_t z) const noexcept;
    [[nodiscard]] PicturePtr picture_on_new_thread(const TileArea& area, Work& work);
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
