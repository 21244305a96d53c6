#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/farm/coordinator/farm.hpp"

namespace terravox::render {

struct RenderPoolOptions {
    int threads = 1;     ///< of this process; 0: none
    bool green = false;  ///< the coordinating thread also traces, in slices
    farm::FarmOptions farm;
    /// How long to wait when no participant is left; nullopt: forever.
    std::optional<std::chrono::milliseconds> give_up;
    /// Participants may change while a picture is under way; for a while there may be none.
    bool changes = false;
};

/// The participants that render the pictures of a world: threads of this process, workers
/// elsewhere, or both.
///
/// Pictures are begun, and the render pool is changed, by one thread at a time; the participants
/// may be queried by any.
class RenderPool {
public:
    /// @param source where workers may get boxes from
    /// @throws UsageError when there is no participant; Error when it cannot listen
    RenderPool(const RenderPoolOptions& options, blocks::BlockManager& blocks,
               const farm::BoxSource& source);
    ~RenderPool();

    /// All participants as one processor, for a picture. When the last owner releases it the
    /// picture ends, with whatever is under way; only then may the next begin.
    /// @param view must outlive the result, as must the render pool
    /// @throws Error
    [[nodiscard]] std::shared_ptr<processors::TileProcessor> begin(const shade::View& view);

    /// Applies from now on, including to the picture under way, where the render pool may change.
    void set_threads(int threads);
    void set_green(bool on);
    /// Dials a worker that listens at this address, repeatedly.
    /// @throws Error
    void dial(const sockets::Address& worker);
    /// Disconnects a worker and stops dialling it.
    /// @param worker as Address::text
    void hang_up(const std::string& worker);
    [[nodiscard]] int threads() const noexcept { return m_options.threads; }
    [[nodiscard]] bool green() const noexcept { return m_options.green; }
    /// Addresses that are dialled, whether connected or not.
    [[nodiscard]] std::vector<std::string> dialled() const {
        return m_farm ? m_farm->dialled() : std::vector<std::string>{};
    }

    /// Whether others than threads of this process take part.
    [[nodiscard]] bool is_farm() const noexcept { return m_farm != nullptr; }
    /// Whether this process traces, apart from tiles that it repeats as checks.
    [[nodiscard]] bool traces_here() const noexcept {
        return m_options.threads > 0 || m_options.green;
    }

    /// A participant that renders now, or rendered the last picture.
    struct Participant {
        processors::ProcessorPool::Status status;
        std::string peer;
        std::uint64_t memory_bytes = 0;
        std::uint64_t received_bytes = 0;
    };
    [[nodiscard]] std::vector<Participant> participants() const;
    [[nodiscard]] processors::ProcessorPool::Counts counts() const;
    /// participants() as lines of text: a heading and one line each; empty if there are only
    /// threads of this process.
    [[nodiscard]] std::vector<std::string> table() const;
    /// Sets the number of tiles and of finished ones, for status queries from outside.
    void set_progress(std::uint64_t tiles_done, std::uint64_t tiles) noexcept {
        m_tiles_done = tiles_done;
        m_tiles = tiles;
    }

private:
    class PictureSession;
    void open_farm();
    [[nodiscard]] farm::Status reported_status() const;

    RenderPoolOptions m_options;
    blocks::BlockManager& m_blocks;
    const farm::BoxSource m_source;
    std::unique_ptr<farm::Farm> m_farm;
    mutable std::mutex m_mutex;
    PictureSession* m_session = nullptr;  ///< of the picture under way
    std::vector<Participant> m_last;
    processors::ProcessorPool::Counts m_last_counts;
    std::atomic<std::uint64_t> m_tiles_done{0};
    std::atomic<std::uint64_t> m_tiles{0};
    const std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
};

}  // namespace terravox::render
