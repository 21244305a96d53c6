#pragma once

#include "raytracer/core/tiles/tile.hpp"

namespace terravox::output {

/// Destination of finished tiles: a Film, or a file (TileStream).
class TileSink {
public:
    TileSink() = default;
    TileSink(const TileSink&) = default;
    TileSink& operator=(const TileSink&) = default;
    virtual ~TileSink() = default;
    /// Not thread-safe.
    /// @throws Error
    virtual void add(const tiles::TileResult& result) = 0;
    /// Whether a tile that is added again replaces the earlier one.
    [[nodiscard]] virtual bool replaces() const noexcept { return false; }
};

}  // namespace terravox::output
