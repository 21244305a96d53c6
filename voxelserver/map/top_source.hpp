#pragma once

#include <cstdint>
#include <memory>

#include "common/voxel/world.hpp"
#include "voxelserver/map/column_top.hpp"

namespace terravox::map {

/// One box column from above, as far as it is known.
struct Top {
    std::shared_ptr<const BoxTop> top;  ///< nullptr: nothing is there, or nothing is known
    bool known = false;                 ///< false: not made yet; only when `make` was false
    voxel::InputExtent reach;           ///< of its boxes; empty = the box column alone
};

/// A square of the map's finest tiles, each 4 x 4 box columns (256 x 256 columns): 2^zooms_out
/// tiles a side, the first one at (x, z) * 2^zooms_out.
struct TileArea {
    int zooms_out = 0;
    std::int32_t x = 0, z = 0;
    friend bool operator==(const TileArea&, const TileArea&) = default;
};
inline constexpr int kTileBoxes = 4;  ///< box columns a side of a finest tile

/// Where the map gets box columns from. Thread-safe; the same column is the same at any time.
class TopSource {
public:
    TopSource() = default;
    TopSource(const TopSource&) = delete;
    TopSource& operator=(const TopSource&) = delete;
    virtual ~TopSource() = default;

    /// @param make false: only what is at hand, and quickly
    /// @throws Error when the column cannot be made
    [[nodiscard]] virtual Top top(std::int32_t bx, std::int32_t bz, bool make) = 0;

    /// A number that grows whenever a column of the area, or of the ring of box columns around it,
    /// comes to hand; 0: none ever did. Quick.
    [[nodiscard]] virtual std::uint64_t version(const TileArea& area) = 0;
};

}  // namespace terravox::map
