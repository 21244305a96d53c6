#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "raytracer/farm/net/link.hpp"
#include "raytracer/farm/worker/picture_context.hpp"

namespace terravox::farm {

/// What all sessions of a daemon share.
struct WorkerShared {
    WorkerShared(std::size_t shelf_bytes, int sessions)
        : shelf(shelf_bytes, static_cast<std::size_t>(sessions) + 1) {}
    BoxShelf shelf;
    std::mutex mutex;
    std::map<std::string, std::string> states;  ///< texts by hash; a few megabytes at most
    std::atomic<std::uint64_t> tiles{0}, pixels{0}, rays{0}, result_bytes{0}, box_requests{0},
        busy_us{0}, failed{0};
};

struct SessionOptions {
    int threads = 1;
    std::size_t memory_bytes = std::size_t{2048} << 20;  ///< for boxes
    /// Servers that it may request boxes from itself.
    remote::HttpAccess http = remote::access_to_nobody();
};

/// A worker's end of a link to a coordinator, after the hellos: renders the requested tiles until
/// the link ends.
///
/// The thread of run() reads frames and waits for nothing else. Each picture has a stage: its
/// world, boxes, view and threads, made on a thread of its own, which then feeds the threads with
/// tiles; others take the results, pack them, and send them.
class WorkerSession {
public:
    WorkerSession(std::unique_ptr<net::Link> link, std::string coordinator, SessionOptions options,
                  WorkerShared& shared);
    ~WorkerSession();

    enum class End : std::uint8_t {
        kLost,     ///< the link ended, or the coordinator sent something invalid
        kBye,      ///< the coordinator has finished
        kRefused,  ///< it refuses this worker
        kDrained,  ///< this worker left
    };
    /// @return how it ended; `why` has details
    /// @throws Error, std::bad_alloc without threads or memory; the link has ended then, too
    End run(std::string& why);

    /// Returns tiles that are not begun, finishes the rest, and ends the link, at the latest after
    /// the timeout. From any thread.
    void drain(std::chrono::milliseconds timeout);
    void abort() noexcept { m_link->abort(); }
    /// Notifies the coordinator that it accepts no more tiles for now, or does again. From any
    /// thread.
    void pause(bool on);

    struct Status {
        std::string coordinator, peer;
        const char* state = "";
        std::uint64_t tiles = 0, pixels = 0;
        std::size_t box_bytes = 0, waiting = 0, begun = 0;
    };
    [[nodiscard]] Status status() const;

private:
    /// @return what is wrong with the frame; empty: nothing
    [[nodiscard]] std::string take(const farm::Frame& frame);
    [[nodiscard]] std::string begin_picture(const farm::Picture& picture);
    [[nodiscard]] std::string begin_stage_if_complete();
    [[nodiscard]] std::string add_task(const farm::Task& task);
    void end_stage();
    void beat();
    [[nodiscard]] farm::Heartbeat heartbeat() const;
    void give_back(const std::vector<std::uint64_t>& ids);

    const std::shared_ptr<net::Link> m_link;
    const std::string m_coordinator;
    const SessionOptions m_options;
    WorkerShared& m_shared;
    // Used by the reader alone.
    std::optional<farm::Picture> m_awaited;      ///< picture whose texts have not all arrived
    std::map<std::string, std::string> m_texts;  ///< texts of that picture, by hash
    std::vector<farm::Task> m_early;             ///< tasks of that picture
    std::size_t m_early_tiles = 0;
    std::shared_ptr<WorkerGround> m_ground;
    /// Cancelled, with threads that may still run.
    std::vector<std::shared_ptr<PictureContext>> m_old;
    std::optional<End> m_end;

    mutable std::mutex m_mutex;
    std::condition_variable m_wake;
    std::shared_ptr<PictureContext> m_stage;
    std::atomic<std::int64_t> m_heard_ns;
    std::atomic<std::uint64_t> m_tiles{0}, m_pixels{0};
    bool m_over = false;
    std::atomic<bool> m_paused{false}, m_draining{false};
};

}  // namespace terravox::farm
