#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
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
    std::atomic<std::uint64_t> tiles{0};
    std::atomic<std::uint64_t> pixels{0};
    std::atomic<std::uint64_t> rays{0};
    std::atomic<std::uint64_t> result_bytes{0};
    std::atomic<std::uint64_t> box_requests{0};
    std::atomic<std::uint64_t> busy_us{0};  ///< CPU time of tracing
    std::atomic<std::uint64_t> failed{0};   ///< tiles that could not be rendered
};

struct SessionOptions {
    int threads = 1;
    std::size_t memory_bytes = std::size_t{2048} << 20;  ///< for boxes
    /// Servers that it may request boxes from itself.
    remote::HttpAccess http = remote::no_http_access();
};

/// A worker's end of a link to a coordinator, after the hellos: renders the requested tiles until
/// the link ends.
///
/// The thread of run() reads frames and waits for nothing else. Each picture has a PictureContext:
/// its world, boxes, view and threads, made on a thread of its own, which then feeds the threads
/// with tiles; others take the results, pack them, and send them.
class WorkerSession {
public:
    WorkerSession(std::unique_ptr<net::Link> link, std::string coordinator, SessionOptions options,
                  WorkerShared& shared);
    ~WorkerSession() { m_link->abort(); }

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
        std::string coordinator;
        std::string peer;
        const char* state = "";
        std::uint64_t tiles = 0;
        std::uint64_t pixels = 0;
        std::size_t box_bytes = 0;
        std::size_t waiting = 0, begun = 0;  ///< leases of the picture under way
    };
    [[nodiscard]] Status status() const;

private:
    /// The picture whose texts have not all arrived, and what has arrived for it. The texts outlive
    /// the wait: they are replaced by those of the next picture.
    struct AwaitedPicture {
        std::optional<farm::Picture> picture;      ///< nullopt: none is awaited
        std::map<std::string, std::string> texts;  ///< by hash
        std::vector<farm::Task> early;             ///< its tasks so far
        std::size_t early_tiles = 0;               ///< tiles of all tasks that arrived early
    };
    /// Tiles of this session that were rendered and sent. Any thread may read and add.
    struct Rendered {
        std::atomic<std::uint64_t> tiles{0};
        std::atomic<std::uint64_t> pixels{0};
    };
    /// Why new tiles are not accepted, if they are not. Any thread may read and write.
    struct Availability {
        std::atomic<bool> paused{false};
        std::atomic<bool> draining{false};
    };

    /// @return what is wrong with the frame; empty: nothing
    [[nodiscard]] std::string take(const farm::Frame& frame);
    [[nodiscard]] std::string begin_picture(const farm::Picture& picture);
    /// Accepts a text of the awaited picture.
    [[nodiscard]] std::string take_text(const farm::State& state);
    void take_stop(const farm::Stop& stop);
    /// @return the texts of the awaited picture; nullopt: some have not arrived, or none is awaited
    [[nodiscard]] std::optional<PictureSpec> arrived_spec() const;
    /// Replaces the world if the picture is of another one.
    /// @param world its metadata, as text
    [[nodiscard]] std::string enter_world(const farm::Picture& picture, const std::string& world);
    void send_done(std::uint64_t picture, std::uint64_t lease, const tiles::TileResult& result);
    /// @param lease 0: the picture as a whole
    void send_failed(std::uint64_t picture, std::uint64_t lease, const std::string& reason);
    /// @return the picture under way; nullptr: none
    [[nodiscard]] std::shared_ptr<PictureContext> current() const;
    [[nodiscard]] std::string begin_picture_if_complete();
    [[nodiscard]] std::string add_task(const farm::Task& task);
    void end_picture();
    void beat();
    [[nodiscard]] farm::Heartbeat heartbeat() const;
    /// @return the word for Status::state
    [[nodiscard]] const char* find_state(bool has_picture) const noexcept;
    void give_back(const std::vector<std::uint64_t>& ids);

    const std::shared_ptr<net::Link> m_link;
    const std::string m_coordinator;
    const SessionOptions m_options;
    WorkerShared& m_shared;
    // Used by the reader alone.
    AwaitedPicture m_awaited;
    std::shared_ptr<WorkerWorld> m_world;
    /// Pictures that are cancelled, with threads that may still run.
    std::vector<std::shared_ptr<PictureContext>> m_old;
    std::optional<End> m_end;

    mutable std::mutex m_mutex;
    std::condition_variable m_wake;
    std::shared_ptr<PictureContext> m_context;
    std::atomic<std::int64_t> m_heard_ns;
    Rendered m_rendered;
    bool m_over = false;
    Availability m_availability;
};

}  // namespace terravox::farm
