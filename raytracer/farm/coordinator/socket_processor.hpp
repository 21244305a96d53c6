#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/farm/net/link.hpp"
#include "raytracer/farm/processors/processor.hpp"

namespace terravox::farm {

/// Renders tiles of one picture on a worker. The link's reader (WorkerLink) passes it the worker's
/// answers.
///
/// One mutex guards leases and results; frames are sent without it. take() throws LostProcessor
/// when the link has ended, UntrustedProcessor when the worker sent something invalid,
/// FailingProcessor when it cannot trace a tile.
class SocketProcessor final : public processors::TileProcessor {
public:
    /// @param picture its id on the wire
    /// @param content that tiles must have
    /// @param blocks of this machine, which must outlive the processor: a box counts as a hole only
    /// when it is not available here either
    SocketProcessor(std::shared_ptr<net::Link> link, std::string name, std::uint64_t picture,
                    tiles::PixelContent content, int capacity, const blocks::BlockManager& blocks);
    [[nodiscard]] int capacity() const noexcept override { return m_capacity; }
    void submit(tiles::RenderTile tile) override;
    [[nodiscard]] bool wait(std::chrono::milliseconds timeout) override;
    std::optional<tiles::TileResult> take() override;
    void withdraw(const tiles::RenderTile& tile) noexcept override;
    void close() noexcept override;
    void cancel() noexcept override;

    [[nodiscard]] std::uint64_t picture() const noexcept { return m_picture; }
    /// Accepts a tile that the worker sent. An invalid one ends the processor.
    void done(const farm::Done& done);
    void failed(const farm::Failed& failed);
    void lost(const std::string& why);
    void misbehaved(const std::string& what);
    /// The tiles of these leases; unknown leases are skipped.
    [[nodiscard]] std::vector<tiles::RenderTile> list_tiles(const std::vector<std::uint64_t>& ids);

private:
    [[nodiscard]] bool has_answer() const noexcept {
        return !m_results.empty() || m_failure || m_cancelled || (m_closed && m_leases.empty());
    }
    void fail(std::exception_ptr failure);
    /// @throws Error for an invalid result
    [[nodiscard]] tiles::TileResult decoded(const std::string& bytes,
                                            const tiles::RenderTile& tile) const;

    const std::shared_ptr<net::Link> m_link;
    const std::string m_name;
    const std::uint64_t m_picture;
    const tiles::PixelContent m_content;
    const int m_capacity;
    const blocks::BlockManager& m_blocks;
    std::mutex m_mutex;
    std::condition_variable m_done;
    std::unordered_map<std::uint64_t, tiles::RenderTile> m_leases;
    std::deque<tiles::TileResult> m_results;
    std::exception_ptr m_failure;
    std::uint64_t m_next_id = 1;
    std::size_t m_strays = 0;  ///< answers that match no request
    bool m_closed = false;
    bool m_cancelled = false;
    bool m_false = false;  ///< the worker sent something invalid
};

}  // namespace terravox::farm
