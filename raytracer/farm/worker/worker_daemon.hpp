#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "raytracer/farm/net/endpoint.hpp"
#include "raytracer/farm/wire/frames.hpp"
#include "raytracer/farm/worker/worker_session.hpp"

namespace terravox::farm {

struct WorkerDaemonOptions {
    std::optional<sockets::Address> listen;
    std::vector<sockets::Address> join;
    net::Credentials credentials;
    std::string name;                                    ///< for display; empty: host and process
    int threads = 1;                                     ///< per session
    std::size_t memory_bytes = std::size_t{2048} << 20;  ///< for boxes, of all sessions
    int sessions = 1;  ///< simultaneous coordinators; others are refused as busy
    /// Servers that it may request boxes from itself; all other boxes come from coordinators.
    remote::HttpAccess http = remote::no_http_access();
    std::chrono::milliseconds timeout{10'000};  ///< for tiles under way when it ends
    bool once = false;                          ///< it ends when the first coordinator has finished
    /// It ends when no coordinator has connected for this long.
    std::optional<std::chrono::milliseconds> idle;
};

/// Lends this machine to coordinators: sessions over links that it accepts or dials.
///
/// One mutex guards the list of sessions. Each link has its own thread (the listener's, or that of
/// the address it joins).
class WorkerDaemon {
public:
    /// @throws Error when it cannot listen, or no thread can be started for an address to join
    explicit WorkerDaemon(WorkerDaemonOptions options);
    ~WorkerDaemon() { finish(); }

    /// Works until `stop` is requested, or an end by `once` or `idle`; then returns tiles that are
    /// not begun and finishes the rest.
    /// @throws Error when nothing is left to do: all addresses to join refuse it
    void run(const std::stop_token& stop);
    /// Changes the options of a running daemon: all but listen, name, credentials, http and once;
    /// sessions under way keep theirs.
    void reload(const WorkerDaemonOptions& options);
    [[nodiscard]] std::uint16_t port() const noexcept {
        return m_listener ? m_listener->port() : 0;
    }

    struct Totals {
        std::uint64_t tiles = 0;
        std::uint64_t pixels = 0;
        std::uint64_t rays = 0;
        std::uint64_t result_bytes = 0;
        std::uint64_t box_requests = 0;
        std::uint64_t sessions = 0;  ///< sessions that were begun
        std::uint64_t busy = 0;      ///< coordinators refused because all places were taken
        std::uint64_t unfit = 0;     ///< coordinators whose hello did not fit
        std::uint64_t failed = 0;    ///< tiles that could not be rendered
        double busy_s = 0;           ///< CPU seconds of tracing
        double uptime_s = 0;
        std::vector<WorkerSession::Status> now;
        int threads = 0;                   ///< of a session
        std::size_t memory_bytes = 0;      ///< limit for boxes
        std::uint64_t resident_bytes = 0;  ///< of the process, in RAM
        bool ending = false;
    };
    [[nodiscard]] Totals totals() const;

    /// Works over a link until it ends. However a session ends, its place is free again then; what
    /// it throws is logged.
    /// @param dialled whether this side dialled: a refusal is final then
    /// @throws std::bad_alloc before the session begins, or while an observer is served
    WorkerSession::End serve(std::unique_ptr<net::Link> link, bool dialled);

private:
    class Place;
    /// What a daemon has counted since its start, about coordinators.
    struct Counters {
        std::uint64_t sessions = 0;  ///< sessions that were begun
        std::uint64_t busy = 0;      ///< coordinators refused because all places were taken
        std::uint64_t unfit = 0;     ///< coordinators whose hello did not fit
    };

    void begin_joining();
    void finish() noexcept;
    void drain(const std::vector<std::shared_ptr<WorkerSession>>& sessions);
    void join_again_and_again(const sockets::Address& address);
    [[nodiscard]] OwnHello hello_for(const SessionOptions& options) const;
    /// Exchanges the hellos.
    /// @return the peer's; nullopt: it does not fit, and `end` says how the link ended
    [[nodiscard]] std::optional<farm::Hello> greet(net::Link& link, const OwnHello& own,
                                                   bool dialled, WorkerSession::End& end);
    [[nodiscard]] WorkerSession::End serve_observer(net::Link& link);
    /// Takes a place for a session, if one is free; only a Place gives it back.
    [[nodiscard]] bool take_place();
    void add(const std::shared_ptr<WorkerSession>& session);
    /// Removes a session that has ended, and frees its place.
    /// @param session  nullptr: there was none yet
    void remove(const std::shared_ptr<WorkerSession>& session, WorkerSession::End end) noexcept;
    [[nodiscard]] bool is_wanted(const sockets::Address& address) const;
    [[nodiscard]] farm::Status status() const;
    void observed(net::Link& link);
    void pause(bool on);
    [[nodiscard]] bool stopped_after(std::chrono::milliseconds time);

    WorkerDaemonOptions m_options;
    WorkerShared m_shared;
    mutable std::mutex m_mutex;
    std::condition_variable m_wake;
    std::vector<std::shared_ptr<WorkerSession>> m_sessions;
    Counters m_counters;
    net::RefusalLog m_refusals;       ///< of peers with which no session begins
    int m_taken = 0;                  ///< places for sessions that are taken
    std::set<std::string> m_joining;  ///< addresses that a thread has joined, or tries to
    bool m_ending = false;
    bool m_finished = false;
    bool m_paused = false;
    const std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point m_idle_since = m_start;
    std::unique_ptr<net::Listener> m_listener;
    std::vector<std::thread> m_threads;
};

}  // namespace terravox::farm
