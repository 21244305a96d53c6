#include "raytracer/farm/worker/worker_daemon.hpp"

#include <algorithm>
#include <random>
#include <utility>

#include "common/thread/start_threads.hpp"
#include "common/util/log.hpp"
#include "common/util/process_memory.hpp"
#include "common/util/version.hpp"
#include "raytracer/farm/processors/thread_processor.hpp"
#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::farm {

using std::chrono::milliseconds;
using End = WorkerSession::End;

namespace {

// Enough for small tiles over a slow connection; the coordinator leases only as many as hide the
// latency.
constexpr int kTilesOfThread = 256;

}  // namespace

WorkerDaemon::WorkerDaemon(WorkerDaemonOptions options)
    : m_options(std::move(options)),
      m_shared(m_options.memory_bytes / 4, m_options.sessions),
      m_refusals({}, "farm: no work for") {
    if (m_options.listen)
        m_listener = std::make_unique<net::Listener>(
            *m_options.listen, m_options.credentials,
            [this](std::unique_ptr<net::Link> link) { (void)serve(std::move(link), false); });
    // The destructor does not run when this throws.
    try {
        begin_joining();
    } catch (...) {
        finish();
        throw;
    }
}

void WorkerDaemon::begin_joining() {
    const std::lock_guard lock(m_mutex);
    for (const sockets::Address& address : m_options.join) {
        if (!m_joining.insert(address.text()).second)
            continue;
        try {
            thread::add_thread(m_threads, "a coordinator to join",
                               [this, address] { join_again_and_again(address); });
        } catch (...) {
            m_joining.erase(address.text());
            throw;
        }
    }
}

bool WorkerDaemon::is_wanted(const sockets::Address& address) const {
    const std::lock_guard lock(m_mutex);
    return !m_ending &&
           std::any_of(m_options.join.begin(), m_options.join.end(),
                       [&](const sockets::Address& a) { return a.text() == address.text(); });
}

void WorkerDaemon::finish() noexcept {
    {
        const std::lock_guard lock(m_mutex);
        m_ending = true;
        for (const auto& session : m_sessions)
            session->abort();
    }
    m_wake.notify_all();
    if (m_listener)
        m_listener->stop();
    for (std::thread& t : m_threads)
        t.join();
}

void WorkerDaemon::run(const std::stop_token& stop) {
    constexpr milliseconds kLook{50};
    while (!stop.stop_requested()) {
        std::unique_lock lock(m_mutex);
        m_wake.wait_for(lock, kLook);
        if (m_finished)
            break;
        if (!m_listener && m_joining.empty() && m_taken == 0)
            throw util::Error("work: no coordinator is left to join");
        if (m_options.idle && m_taken == 0 &&
            std::chrono::steady_clock::now() - m_idle_since > *m_options.idle) {
            util::log_info(
                "no coordinator for {} s: the worker ends",
                std::chrono::duration_cast<std::chrono::seconds>(*m_options.idle).count());
            break;
        }
    }
    std::vector<std::shared_ptr<WorkerSession>> sessions;
    {
        const std::lock_guard lock(m_mutex);
        m_ending = true;
        sessions = m_sessions;
    }
    m_wake.notify_all();
    if (!sessions.empty())
        util::log_info("finishing what is begun");
    drain(sessions);
    // Links are flushed: the coordinator closes them once it has read the goodbye.
    std::unique_lock lock(m_mutex);
    m_wake.wait_for(lock, milliseconds(2000), [&] { return m_sessions.empty(); });
}

// All in parallel, as they share the time limit; those for which no thread can be started are
// ended.
void WorkerDaemon::drain(const std::vector<std::shared_ptr<WorkerSession>>& sessions) {
    std::vector<std::thread> threads;
    for (const auto& session : sessions) {
        try {
            thread::add_thread(threads, "the end of a session",
                               [&, session] { session->drain(m_options.timeout); });
        } catch (const std::exception& e) {
            util::log_warn("{}; its tiles under way are given up", e.what());
            session->abort();
        }
    }
    for (std::thread& t : threads)
        t.join();
}

bool WorkerDaemon::stopped_after(milliseconds time) {
    std::unique_lock lock(m_mutex);
    return m_wake.wait_for(lock, time, [&] { return m_ending; });
}

void WorkerDaemon::reload(const WorkerDaemonOptions& options) {
    {
        const std::lock_guard lock(m_mutex);
        m_options.threads = options.threads;
        m_options.memory_bytes = options.memory_bytes;
        m_options.sessions = options.sessions;
        m_options.timeout = options.timeout;
        m_options.idle = options.idle;
        m_options.join = options.join;
    }
    begin_joining();
    m_wake.notify_all();
}

OwnHello WorkerDaemon::hello_for(const SessionOptions& options) const {
    OwnHello out;
    out.role = farm::WORKER;
    out.threads = options.threads;
    out.memory_bytes = options.memory_bytes;
    out.name = m_options.name;
    out.capacity = std::min(options.threads * kTilesOfThread,
                            static_cast<int>(PictureContext::kMaxWaiting) / 4);
    return out;
}

bool WorkerDaemon::take_place() {
    const std::lock_guard lock(m_mutex);
    if (m_taken >= m_options.sessions) {
        ++m_counters.busy;
        return false;
    }
    ++m_taken;
    ++m_counters.sessions;
    return true;
}

void WorkerDaemon::add(const std::shared_ptr<WorkerSession>& session) {
    bool paused = false;
    {
        const std::lock_guard lock(m_mutex);
        m_sessions.push_back(session);
        if (m_ending)
            session->abort();
        paused = m_paused;
    }
    if (paused)
        session->pause(true);
}

void WorkerDaemon::remove(const std::shared_ptr<WorkerSession>& session,
                          WorkerSession::End end) noexcept {
    {
        const std::lock_guard lock(m_mutex);
        std::erase(m_sessions, session);
        --m_taken;
        m_idle_since = std::chrono::steady_clock::now();
        if (m_options.once && end == WorkerSession::End::kBye)
            m_finished = true;
    }
    m_wake.notify_all();
}

/// A place for a session that take_place() has taken, and the session in it once it has begun. The
/// destructor removes the session and frees the place, whatever ends the work.
class WorkerDaemon::Place {
public:
    explicit Place(WorkerDaemon& daemon) noexcept : m_daemon(daemon) {}
    ~Place() { m_daemon.remove(m_session, m_end); }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

    /// Works until the session ends.
    /// @param why details of the end
    /// @throws as WorkerSession::run; Error, std::bad_alloc
    [[nodiscard]] End run(std::shared_ptr<WorkerSession> session, std::string& why) {
        m_session = std::move(session);
        m_daemon.add(m_session);
        m_end = m_session->run(why);
        return m_end;
    }

private:
    WorkerDaemon& m_daemon;
    std::shared_ptr<WorkerSession> m_session;
    End m_end = End::kLost;
};

std::optional<farm::Hello> WorkerDaemon::greet(net::Link& link, const OwnHello& own, bool dialled,
                                               End& end) {
    try {
        return meet(link, make_hello(own), {farm::COORDINATOR, farm::OBSERVER});
    } catch (const util::Error& e) {
        const auto* met = dynamic_cast<const HelloError*>(&e);
        const std::lock_guard lock(m_mutex);
        m_refusals.refused(sockets::to_neighbourhood(link.peer()), link.peer(),
                           met != nullptr ? met->reason : e.what());
        ++m_counters.unfit;
        end = met != nullptr && !met->busy && dialled ? End::kRefused : End::kLost;
        return std::nullopt;
    }
}

WorkerSession::End WorkerDaemon::serve_observer(net::Link& link) {
    try {
        observed(link);
        return End::kBye;
    } catch (const util::Error& e) {
        util::log_warn("{}", e.what());
        return End::kLost;
    }
}

WorkerSession::End WorkerDaemon::serve(std::unique_ptr<net::Link> link, bool dialled) {
    SessionOptions options;
    {
        const std::lock_guard lock(m_mutex);
        if (m_ending)
            return End::kDrained;
        options.threads = m_options.threads;
        options.memory_bytes =
            m_options.memory_bytes / static_cast<std::size_t>(std::max(m_options.sessions, 1));
        options.http = m_options.http;
    }
    const OwnHello own = hello_for(options);
    const std::string peer = link->peer();
    End end = End::kLost;
    const std::optional<farm::Hello> hello = greet(*link, own, dialled, end);
    if (!hello)
        return end;
    if (hello->role() == farm::OBSERVER)
        return serve_observer(*link);
    if (!take_place()) {
        const std::string name = own.name.empty() ? "the worker" : own.name;
        refuse(*link, name + " works for another coordinator", true);
        return End::kLost;
    }
    Place place(*this);
    std::string why;
    try {
        util::log_info("works for {} at {}", hello->name(), peer);
        end = place.run(
            std::make_shared<WorkerSession>(std::move(link), hello->name(), options, m_shared),
            why);
    } catch (const std::exception& e) {  // out of memory, or of threads
        why = e.what();
    }
    if (end == End::kBye)
        util::log_info("{} has finished", peer);
    else if (end == End::kLost)
        util::log_warn("{} is lost: {}", peer, why);
    return end;
}

void WorkerDaemon::observed(net::Link& link) {
    while (auto frame = link.receive()) {
        if (link.is_revoked())
            return refuse(link, "its certificate is revoked");
        if (frame->has_pause())
            pause(frame->pause().on());
        else if (!frame->has_status_request())
            return;
        farm::Frame reply;
        *reply.mutable_status() = status();
        if (!link.send(std::move(reply)))
            return;
    }
}

void WorkerDaemon::pause(bool on) {
    std::vector<std::shared_ptr<WorkerSession>> sessions;
    {
        const std::lock_guard lock(m_mutex);
        if (std::exchange(m_paused, on) != on)
            util::log_info("{}", on ? "paused: no new tiles are taken" : "tiles are taken again");
        sessions = m_sessions;
    }
    for (const auto& session : sessions)
        session->pause(on);
}

void WorkerDaemon::join_again_and_again(const sockets::Address& address) {
    RedialPause pause(std::random_device{}());
    bool reported = false;
    const auto leave = [&] {
        const std::lock_guard lock(m_mutex);
        m_joining.erase(address.text());
        m_wake.notify_all();
    };
    while (is_wanted(address)) {
        try {
            auto link = net::dial(address, m_options.credentials, std::chrono::seconds(5));
            const auto end = serve(std::move(link), true);
            if (end == WorkerSession::End::kRefused)
                return leave();
            if (end == WorkerSession::End::kBye)
                pause.reset();
            reported = false;
        } catch (const net::RefusedError& e) {
            util::log_error("{}", e.what());
            return leave();
        } catch (const std::exception& e) {
            if (!std::exchange(reported, true))
                util::log_info("{}; trying again", e.what());
        }
        if (stopped_after(pause.next()))
            break;
    }
    leave();
}

WorkerDaemon::Totals WorkerDaemon::totals() const {
    Totals out;
    out.tiles = m_shared.tiles;
    out.pixels = m_shared.pixels;
    out.rays = m_shared.rays;
    out.result_bytes = m_shared.result_bytes;
    out.box_requests = m_shared.box_requests;
    out.failed = m_shared.failed;
    out.busy_s = static_cast<double>(m_shared.busy_us) / 1e6;
    out.uptime_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
    out.resident_bytes = util::resident_bytes();
    std::vector<std::shared_ptr<WorkerSession>> sessions;
    {
        const std::lock_guard lock(m_mutex);
        sessions = m_sessions;
        out.sessions = m_counters.sessions;
        out.busy = m_counters.busy;
        out.unfit = m_counters.unfit;
        out.threads = m_options.threads;
        out.memory_bytes = m_options.memory_bytes;
        out.ending = m_ending;
    }
    for (const auto& session : sessions)
        out.now.push_back(session->status());
    return out;
}

farm::Status WorkerDaemon::status() const {
    const Totals totals = this->totals();
    farm::Status out;
    out.set_role(farm::WORKER);
    out.set_name(make_hello({farm::WORKER, 0, 0, 0, m_options.name}).name());
    out.set_software(std::string("terravox ") + kVersion);
    out.set_uptime_s(totals.uptime_s);
    out.set_tiles_done(totals.tiles);
    out.set_memory_bytes(totals.resident_bytes);
    for (const WorkerSession::Status& s : totals.now) {
        farm::Status::Member& m = *out.add_members();
        m.set_name(s.coordinator);
        m.set_kind("coordinator");
        m.set_peer(s.peer);
        m.set_state(s.state);
        m.set_threads(static_cast<std::uint32_t>(totals.threads));
        m.set_tiles(s.tiles);
        m.set_pixels(s.pixels);
        m.set_memory_bytes(s.box_bytes);
        m.set_leases(static_cast<std::uint32_t>(s.waiting + s.begun));
    }
    return out;
}

}  // namespace terravox::farm
