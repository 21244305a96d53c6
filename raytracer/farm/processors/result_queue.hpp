#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <unordered_set>
#include <vector>

#include "raytracer/core/tiles/tile.hpp"

namespace terravox::processors {

/// Finished tiles for the caller, which takes each tile of a pass once. A tile whose pixels turn
/// out to be wrong is invalidated: if the caller has taken it already, it is returned again
/// (TileResult::again). Not thread-safe.
class ResultQueue {
public:
    /// Announces a tile that the caller will take. The first tile of another pass begins that pass.
    void expect(const tiles::RenderTile& tile);
    /// @return whether expect(tile) would begin another pass
    [[nodiscard]] bool begins_pass(const tiles::RenderTile& tile) const noexcept;

    void push(tiles::TileResult&& result);
    /// Whether there is a tile to take. The last tile is kept back until no tile can be invalidated
    /// any more, as it ends the picture.
    /// @param checks_open whether some checks are not answered yet
    [[nodiscard]] bool can_take(bool checks_open) const noexcept;
    /// @pre can_take()
    [[nodiscard]] tiles::TileResult take();

    /// To be called when a finished tile is computed again.
    void invalidate(std::uint32_t index);
    /// @return indices of tiles that had been taken when they were invalidated, since the last call
    [[nodiscard]] std::vector<std::uint32_t> take_invalidated();

    /// @return whether so many tiles wait for the caller that members must wait, to bound the
    /// memory
    [[nodiscard]] bool is_full() const noexcept { return m_ready.size() > kMaxReady; }
    /// @return tiles that are still to be taken, for the first time or again
    [[nodiscard]] std::size_t tiles_left() const noexcept { return m_first_left + m_again_left; }
    /// @return tiles that are still to be taken again
    [[nodiscard]] std::size_t again_left() const noexcept { return m_again_left; }
    /// @return whether samples of this pass are merged with those of earlier ones
    [[nodiscard]] bool is_merged() const noexcept { return m_pass.first_sample != 0; }

private:
    static constexpr std::size_t kMaxReady = 1024;
    struct Pass {
        std::uint32_t pass = 0;
        std::uint32_t first_sample = 0;
        friend bool operator==(const Pass&, const Pass&) = default;
    };
    [[nodiscard]] static Pass pass_of(const tiles::RenderTile& tile) noexcept {
        return {tile.pass, tile.first_sample};
    }

    std::deque<tiles::TileResult> m_ready;
    std::vector<std::uint32_t> m_invalidated;
    std::unordered_set<std::uint32_t> m_taken;  ///< tiles of this pass
    Pass m_pass;
    std::size_t m_first_left = 0;
    std::size_t m_again_left = 0;
};

}  // namespace terravox::processors
