#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/farm/coordinator/farm.hpp"

namespace terravox::render {

struct RenderPoolOptions {
    int threads = 1;     ///< of this process; 0: none
    bool green = false;  ///< the thread that coordinates traces, too, in slices
    farm::FarmOptions farm;
    std::optional<std::chrono::milliseconds>
        give_up;           ///< how long to wait when nobody is left; none: for ever
    bool changes = false;  ///< who takes part may change while a picture is under way; there may be
                           ///< nobody for a while
};

/// Who renders the pictures of a world: threads of this process, workers elsewhere, or both.
///
/// Pictures are begun, and the render pool is changed, by one thread at a time; who takes part may
/// be asked by any.
class RenderPool {
public:
    /// @param source where workers may have boxes from @throws UsageError when nobody is left to
    /// render; Error when it cannot listen
    RenderPool(const RenderPoolOptions& options, blocks::BlockManager& blocks,
               const farm::BoxSource& source);
    ~RenderPool();

    /// All of them as one, for a picture. When the last owner lets go the picture ends, whatever is
    /// under way; only then the next may begin.
    /// @param view outlives what is returned; the render pool does, too @throws Error
    [[nodiscard]] std::shared_ptr<processors::TileProcessor> begin(const shade::View& view);

    /// From now on, and for the picture under way, where the render pool changes.
    void set_threads(int threads);
    void set_green(bool on);
    /// A worker that listens there is dialled, again and again. @throws Error
    void dial(const sockets::Address& worker);
    /// It is sent away, and not dialled any more. @param worker as Address::text
    void hang_up(const std::string& worker);
    [[nodiscard]] int threads() const noexcept { return m_options.threads; }
    [[nodiscard]] bool green() const noexcept { return m_options.green; }
    /// Addresses that are dialled, there or not.
    [[nodiscard]] std::vector<std::string> dialled() const {
        return m_farm ? m_farm->dialled() : std::vector<std::string>{};
    }

    /// Whether others than threads of this process take part.
    [[nodiscard]] bool is_farm() const noexcept { return m_farm != nullptr; }
    /// Whether this process traces, beside what it makes again for checks.
    [[nodiscard]] bool traces_here() const noexcept {
        return m_options.threads > 0 || m_options.green;
    }

    /// Those who render now, or rendered the last picture.
    struct Participant {
        processors::ProcessorPool::Status status;
        std::string peer;
        std::uint64_t memory_bytes = 0, received_bytes = 0;
    };
    [[nodiscard]] std::vector<Participant> participants() const;
    [[nodiscard]] processors::ProcessorPool::Counts counts() const;
    /// participants() in lines for a person: a heading and one for each; empty where it is threads
    /// of this process alone.
    [[nodiscard]] std::vector<std::string> table() const;
    /// How many tiles there are, and how many are done, for who asks from outside.
    void set_progress(std::uint64_t tiles_done, std::uint64_t tiles) noexcept {
        m_tiles_done = tiles_done;
        m_tiles = tiles;
    }

private:
    class PictureSession;
    void open_farm();
    [[nodiscard]] farm::Status told_status() const;

    RenderPoolOptions m_options;
    blocks::BlockManager& m_blocks;
    const farm::BoxSource m_source;
    std::unique_ptr<farm::Farm> m_farm;
    mutable std::mutex m_mutex;
    PictureSession* m_session = nullptr;  ///< of the picture under way
    std::vector<Participant> m_last;
    processors::ProcessorPool::Counts m_last_counts;
    std::atomic<std::uint64_t> m_tiles_done{0}, m_tiles{0};
    const std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
};

}  // namespace terravox::render
