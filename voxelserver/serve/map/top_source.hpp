#pragma once

#include <cstdint>
#include <memory>

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

}  // namespace terravox::map
