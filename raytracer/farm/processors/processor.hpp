#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "raytracer/core/tiles/tile.hpp"

namespace terravox::processors {

/// Turns tiles into results: on the caller's thread, on threads of its own, or over a socket. The
/// pixels do not depend on which.
class TileProcessor {
public:
    TileProcessor() = default;
    TileProcessor(const TileProcessor&) = delete;
    TileProcessor& operator=(const TileProcessor&) = delete;
    virtual ~TileProcessor() = default;
    /// Number of tiles that it can use at once, at least 1.
    [[nodiscard]] virtual int capacity() const noexcept = 0;
    /// Blocks while full. Thread-safe. Ignored once closed.
    virtual void submit(tiles::RenderTile tile) = 0;
    /// Waits until take() has an answer, or the timeout has passed.
    /// @return whether it has
    [[nodiscard]] virtual bool wait(std::chrono::milliseconds timeout) = 0;
    /// @return a finished tile, or nullopt once closed and drained
    /// @throws whatever the tile's task threw, with its type kept
    virtual std::optional<tiles::TileResult> take() = 0;
    /// Indices of tiles that were taken, and will be returned again because their pixels are not
    /// trustworthy; each once.
    [[nodiscard]] virtual std::vector<std::uint32_t> take_invalidated() { return {}; }
    /// Removes the tiles that are not begun.
    /// @return those tiles
    [[nodiscard]] virtual std::vector<tiles::RenderTile> take_back() { return {}; }
    /// Cancels a tile whose result is not needed any more; it may be returned all the same.
    virtual void withdraw(const tiles::RenderTile& /*tile*/) noexcept {}
    /// Accepts no more tiles; those accepted are finished. Idempotent.
    virtual void close() noexcept = 0;
    /// As close(), but tiles not yet begun are dropped, and those begun end early, without a
    /// result.
    virtual void cancel() noexcept = 0;
};

}  // namespace terravox::processors
