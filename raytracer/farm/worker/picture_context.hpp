#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "raytracer/farm/net/link.hpp"
#include "raytracer/farm/processors/thread_processor.hpp"
#include "raytracer/farm/wire/picture_spec.hpp"
#include "raytracer/farm/worker/coordinator_world.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"

namespace terravox::farm {

/// A world on a worker, with its boxes in memory: kept from one picture to the next of the same
/// world.
struct WorkerWorld {
    std::uint64_t world_id = 0;
    std::string info_text;          ///< the world's metadata, as received (PictureSpec::world)
    std::string server, generated;  ///< source of boxes, as in BoxSource
    /// Servers that this worker may request from itself.
    remote::HttpAccess http = remote::no_http_access();
    std::unique_ptr<CoordinatorWorld> coordinator;
    /// Opened by the first picture; nullptr: boxes come from the coordinator.
    std::unique_ptr<voxel::World> own;
    std::unique_ptr<blocks::BlockManager> blocks;
    std::mutex opening;
    std::stop_source ending;

    /// Makes requests and opening under way end soon.
    void stop() noexcept {
        coordinator->stop();
        ending.request_stop();
    }
};

/// One picture on a worker: the preparation before the first tile, then the rendering of tiles on
/// threads.
///
/// A thread of its own opens the world and makes the view, then feeds tiles to the threads; other
/// threads take results and pass them on. One mutex guards the waiting tiles and those begun. Only
/// as many are begun as fit the memory: together they may take as much as the boxes, and one may
/// always be begun. A tile whose pixels would not fit a frame is refused. The context ends,
/// cancelled, on end(); the destructor waits for the threads.
class PictureContext {
public:
    /// Callbacks for results. Called on threads of the context.
    struct Answers {
        std::function<void(std::uint64_t id, tiles::TileResult)> done;
        /// @param id of the lease that cannot be rendered here; 0: the picture as a whole
        std::function<void(std::uint64_t id, const std::string& why)> failed;
    };
    /// @throws Error when no thread can be started; later refusals are reported by Answers::failed
    PictureContext(std::uint64_t picture, PictureSpec spec, std::shared_ptr<WorkerWorld> world,
                   int threads, std::size_t memory_bytes, Answers answers);
    ~PictureContext() { end(); }

    [[nodiscard]] std::uint64_t picture() const noexcept { return m_picture; }
    void add(std::uint64_t id, const tiles::RenderTile& tile);
    /// Cancels leases: their results are not reported, unless they are on their way.
    void drop(const std::vector<std::uint64_t>& ids);
    /// Cancels all tiles that are not begun.
    /// @return their leases
    [[nodiscard]] std::vector<std::uint64_t> drop_all();
    void cancel() noexcept;
    /// Cancels, and waits for all threads: no callback is called after this.
    void end() noexcept;
    /// Whether all its threads have ended.
    [[nodiscard]] bool is_over() const noexcept { return m_over; }
    /// Waits until no tile is in progress, at most until the given time.
    bool wait_idle(std::chrono::steady_clock::time_point until);
    struct Load {
        std::size_t waiting = 0;
        std::size_t begun = 0;
        std::size_t box_bytes = 0;
    };
    [[nodiscard]] Load load() const;
    static constexpr std::size_t kMaxWaiting = 1 << 16;
    /// Limit of a lease's pixels, uncompressed: what compresses to a frame's size
    /// (net::kMaxFrame_bytes) has at most twice that.
    static constexpr std::uint64_t kMaxLease_bytes = 2 * net::kMaxFrame_bytes;
    [[nodiscard]] const WorkerWorld& world() const noexcept { return *m_world; }

private:
    void run();
    void trace();
    /// Opens the world unless an earlier picture has.
    /// @return false: it was stopped
    [[nodiscard]] bool open_world();
    void feed(processors::TileProcessor& processor, tiles::PixelContent content);
    [[nodiscard]] bool has_room(const tiles::RenderTile& tile, tiles::PixelContent content) const;
    void collect(processors::TileProcessor& processor);

    const std::uint64_t m_picture;
    const PictureSpec m_spec;
    const std::shared_ptr<WorkerWorld> m_world;
    const int m_threads;
    const std::size_t m_memory_bytes;
    const Answers m_answers;
    mutable std::mutex m_mutex;
    std::condition_variable m_work;
    std::condition_variable m_idle;
    std::deque<std::pair<std::uint64_t, tiles::RenderTile>> m_waiting;
    std::vector<std::pair<std::uint64_t, tiles::RenderTile>> m_begun;
    processors::TileProcessor* m_processor = nullptr;
    bool m_cancelled = false;
    std::atomic<bool> m_over{false};
    std::thread m_thread;
    std::once_flag m_joined;
};

}  // namespace terravox::farm
