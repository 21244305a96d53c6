#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "raytracer/tiles/tile.hpp"

namespace terravox::processors {

/// Turns tiles into results, wherever: on this stack, on threads, across a socket. The pixels do
/// not depend on which.
class TileProcessor {
public:
    TileProcessor() = default;
    TileProcessor(const TileProcessor&) = delete;
    TileProcessor& operator=(const TileProcessor&) = delete;
    virtual ~TileProcessor() = default;
    [[nodiscard]] virtual int capacity()
        const noexcept = 0;  ///< tiles that it has use for at once, at least 1
    virtual void submit(
        tiles::RenderTile tile) = 0;  ///< blocks while full; thread-safe; ignored once closed
    /// Waits until take() has an answer, but no longer than this. @return whether it has
    [[nodiscard]] virtual bool wait(std::chrono::milliseconds most) = 0;
    /// @return a finished tile, or nullopt once closed and drained
    /// @throws whatever the tile's task threw, with its type kept
    virtual std::optional<tiles::TileResult> take() = 0;
    /// Indices of tiles that were taken, and come again because who made them was not to be
    /// trusted: each once.
    [[nodiscard]] virtual std::vector<std::uint32_t> take_invalidated() { return {}; }
    /// Tiles that are submitted and not begun: it will not trace them.
    [[nodiscard]] virtual std::vector<tiles::RenderTile> take_back() { return {}; }
    /// Its result is not needed any more; it may come all the same.
    virtual void withdraw(const tiles::RenderTile& /*tile*/) noexcept {}
    virtual void
    close() noexcept = 0;  ///< no more tiles will come; those accepted are finished; idempotent
    virtual void cancel() noexcept = 0;  ///< as close(), but tiles not yet begun are dropped and
                                         ///< those begun end early, without result
};

}  // namespace terravox::processors
