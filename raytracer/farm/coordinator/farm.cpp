#include "raytracer/farm/coordinator/farm.hpp"

#include <algorithm>
#include <random>
#include <set>
#include <utility>

#include "common/thread/start_threads.hpp"
#include "common/util/log.hpp"
#include "raytracer/farm/wire/frames.hpp"
#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::farm {
namespace {

constexpr int kSupplierThreads = 3;
constexpr std::size_t kMaxReasons = 16;  ///< that are logged of one address

/// A worker as the list of bans knows it.
BanList::Worker for_bans(const WorkerLink& worker, const std::string& dialled) {
    return {worker.hello().name(), worker.peer(), dialled};
}

/// An identity that a worker cannot have many of; the name in its hello can be chosen freely.
/// Machines that share a certificate count as one, which only makes the pool tolerate
/// more failures.
std::string make_identity(const WorkerLink& worker) {
    const std::string& name = worker.certified_name();
    return name.empty() ? "host " + sockets::to_neighbourhood(worker.peer())
                        : "certificate " + name;
}

// In parallel, as each waits for its worker to read it; one after the other if no threads can be
// started.
void say_goodbye(const std::vector<std::shared_ptr<WorkerLink>>& links) noexcept {
    constexpr const char* kWhy = "the coordinator has finished";
    std::vector<std::thread> threads;
    for (const auto& link : links) {
        try {
            thread::add_thread(threads, "a goodbye", [link] { link->bye(kWhy); });
        } catch (const std::exception&) {
            link->bye(kWhy);
        }
    }
    for (std::thread& t : threads)
        t.join();
}

std::uint64_t random_number() {
    std::random_device device;
    return std::uint64_t{device()} << 32 | device();
}

}  // namespace

Farm::Farm(FarmOptions options, blocks::BlockManager& blocks, BoxSource source)
    : m_options(std::move(options)),
      m_blocks(blocks),
      m_source(std::move(source)),
      m_supplier(blocks, random_number(), blocks.limit_bytes() / 4, kSupplierThreads),
      m_refusals({}, "farm: no work with") {
    if (m_options.listen)
        m_listener = std::make_unique<net::Listener>(
            *m_options.listen, m_options.credentials,
            [this](std::unique_ptr<net::Link> link) { (void)serve(std::move(link), ""); });
    if (m_listener)
        util::log_info("waiting for workers on port {}", m_listener->port());
    // The destructor does not run when this throws.
    try {
        for (const sockets::Address& address : m_options.dial)
            dial(address);
        const std::lock_guard lock(m_mutex);
        thread::add_thread(m_threads, "the links of the farm", [this] { watch(); });
    } catch (...) {
        finish();
        throw;
    }
}

void Farm::finish() noexcept {
    end();
    std::vector<std::shared_ptr<WorkerLink>> links;
    {
        const std::lock_guard lock(m_mutex);
        m_stop = true;
        for (const auto& [id, entry] : m_connected.workers)
            links.push_back(entry.link);
    }
    m_wake.notify_all();
    say_goodbye(links);
    if (m_listener)
        m_listener->stop();
    for (const auto& link : links)
        link->abort();
    for (std::thread& t : m_threads)
        t.join();
}

void Farm::begin(processors::ProcessorPool& pool, const scene::Scene& scene,
                 const shade::View& view) {
    PictureCall call;
    call.world_id = m_supplier.world_id();
    call.spec = pack(scene, m_blocks.world_info());
    call.source = m_source;
    call.content = view.content();
    const std::lock_guard lock(m_mutex);
    call.id = m_picture.next_id++;
    m_picture.call = std::move(call);
    m_picture.pool = &pool;
    for (auto& [id, entry] : m_connected.workers)
        attach(entry);
}

void Farm::end() {
    const std::lock_guard lock(m_mutex);
    m_picture.pool = nullptr;
    m_picture.call.reset();
    for (auto& [id, entry] : m_connected.workers)
        entry.member = 0;
}

void Farm::attach(ConnectedWorker& entry) {
    if (m_picture.pool == nullptr || !entry.accepted || entry.link->draining())
        return;
    const farm::Hello& hello = entry.link->hello();
    processors::ProcessorPool::Member member{hello.name(),
                                             "socket",
                                             static_cast<int>(hello.threads()),
                                             false,
                                             false,
                                             entry.link->begin(*m_picture.call),
                                             [link = entry.link] { return link->latency_s(); }};
    member.paused = entry.takes_nothing();
    member.identity = make_identity(*entry.link);
    const auto processor = member.processor;
    try {
        entry.member = m_picture.pool->add(std::move(member));
    } catch (const std::exception& e) {  // out of threads or memory: the others continue
        util::log_error("worker {} is excluded from the picture: {}", hello.name(), e.what());
        processor->cancel();
    }
}

void Farm::gone(processors::ProcessorPool::MemberId member, const std::string& why, bool expelled) {
    std::shared_ptr<WorkerLink> link;
    {
        const std::lock_guard lock(m_mutex);
        for (auto& [id, entry] : m_connected.workers)
            if (entry.member == member) {
                link = entry.link;
                entry.member = 0;
                if (expelled)
                    m_bans.ban(for_bans(*link, entry.dialled));
            }
    }
    if (!link)
        return;
    if (expelled) {
        util::log_error("worker {} at {} is expelled: {}", link->hello().name(), link->peer(), why);
        link->refuse_it("expelled: " + why);
    } else if (link->draining()) {
        util::log_info("worker {} has left", link->hello().name());
    } else {
        util::log_warn("worker {} at {} is lost: {}", link->hello().name(), link->peer(), why);
    }
}

bool Farm::is_banned(const BanList::Worker& worker) const {
    const std::lock_guard lock(m_mutex);
    return m_bans.has(worker);
}

bool Farm::pause(const std::string& worker, bool on) {
    const std::lock_guard lock(m_mutex);
    bool found = false;
    for (auto& [id, entry] : m_connected.workers) {
        if (!worker.empty() && entry.link->hello().name() != worker)
            continue;
        entry.paused = on;
        found = true;
        if (m_picture.pool != nullptr && entry.member != 0)
            m_picture.pool->pause(entry.member, entry.takes_nothing());
    }
    return found;
}

void Farm::set_status_source(std::function<farm::Status()> source) {
    const std::lock_guard lock(m_mutex);
    m_status_source = std::move(source);
}

void Farm::observe(net::Link& link) {
    while (auto frame = link.receive()) {
        if (link.is_revoked())
            return refuse(link, "its certificate is revoked");
        if (frame->has_pause() && !pause(frame->pause().worker(), frame->pause().on()))
            return refuse(link, "no such worker: '" + frame->pause().worker().substr(0, 200) + "'");
        if (!frame->has_pause() && !frame->has_status_request())
            return;
        std::function<farm::Status()> source;
        {
            const std::lock_guard lock(m_mutex);
            source = m_status_source;
        }
        farm::Frame reply;
        reply.mutable_status();
        if (source)
            *reply.mutable_status() = source();
        if (!link.send(std::move(reply)))
            return;
    }
}

std::optional<farm::Hello> Farm::greet(net::Link& link, const std::string& dialled) {
    farm::Hello hello =
        meet(link, make_hello({}),
             dialled.empty() ? std::initializer_list<farm::Role>{farm::WORKER, farm::OBSERVER}
                             : std::initializer_list<farm::Role>{farm::WORKER});
    if (hello.role() == farm::OBSERVER) {
        observe(link);
        return std::nullopt;
    }
    if (is_banned({hello.name(), link.peer(), dialled})) {
        refuse(link, "expelled before");
        return std::nullopt;
    }
    return hello;
}

WorkerLink::Reported Farm::make_notifications(std::uint64_t id) {
    // Calls `act` with the lock held, if the worker is assigned to a pool.
    const auto with_entry = [this, id](const auto& act) {
        const std::lock_guard lock(m_mutex);
        const auto entry = m_connected.workers.find(id);
        if (entry != m_connected.workers.end() && entry->second.member != 0 &&
            m_picture.pool != nullptr)
            act(entry->second);
    };
    WorkerLink::Reported out;
    out.accepts = [this, id] { welcome(id); };
    out.drains = [this, with_entry](const std::vector<tiles::RenderTile>& given_back) {
        with_entry(
            [&](ConnectedWorker& entry) { m_picture.pool->drain(entry.member, given_back); });
    };
    out.pauses = [this, with_entry](bool) {
        with_entry([&](ConnectedWorker& entry) {
            m_picture.pool->pause(entry.member, entry.takes_nothing());
        });
    };
    return out;
}

void Farm::remove(std::uint64_t id, const WorkerLink& worker, const std::string& dialled,
                  const std::string& why) {
    processors::ProcessorPool* pool = nullptr;
    processors::ProcessorPool::MemberId member = 0;
    {
        const std::lock_guard lock(m_mutex);
        const auto entry = m_connected.workers.find(id);
        member = entry->second.member;
        pool = m_picture.pool;
        m_connected.workers.erase(entry);
        if (worker.misbehaved())
            m_bans.ban(for_bans(worker, dialled));
    }
    if (member == 0 || pool == nullptr)
        return;
    const std::string& name = worker.hello().name();
    if (worker.misbehaved())
        util::log_error("worker {} at {} is expelled: {}", name, worker.peer(), why);
    else if (worker.draining())
        util::log_info("worker {} has left", name);
    else
        util::log_warn("worker {} at {} is lost: {}", name, worker.peer(), why);
}

void Farm::welcome(std::uint64_t id) {
    const std::lock_guard lock(m_mutex);
    const auto found = m_connected.workers.find(id);
    if (found == m_connected.workers.end())
        return;
    ConnectedWorker& entry = found->second;
    const farm::Hello& hello = entry.link->hello();
    util::log_info("worker {} at {}: {} threads, {}", hello.name(), entry.link->peer(),
                   hello.threads(), hello.cpu_features());
    entry.accepted = true;
    attach(entry);
}

LinkOutcome Farm::serve(std::unique_ptr<net::Link> link, const std::string& dialled) {
    const std::string peer = link->peer();
    LinkOutcome out = serve_worker(std::move(link), dialled);
    // A worker that dialled in is known by its address alone, and may come again at once.
    if (dialled.empty() && !out.why.empty()) {
        const std::lock_guard lock(m_mutex);
        m_refusals.refused(sockets::to_neighbourhood(peer), peer, out.why);
    }
    return out;
}

LinkOutcome Farm::serve_worker(std::unique_ptr<net::Link> link, const std::string& dialled) {
    using Kind = LinkOutcome::Kind;
    std::shared_ptr<WorkerLink> worker;
    std::uint64_t id = 0;
    try {
        std::optional<farm::Hello> hello = greet(*link, dialled);
        if (!hello)
            return {};
        const std::lock_guard lock(m_mutex);
        if (m_stop || (!dialled.empty() && !m_dialled.has(dialled)))
            return {};  // it was sent away before it was registered
        id = m_connected.next_id++;
        WorkerLink::Reported reported = make_notifications(id);
        worker = std::make_shared<WorkerLink>(std::move(link), *std::move(hello), m_supplier,
                                              std::move(reported));
        m_connected.workers.emplace(id, ConnectedWorker{worker, dialled});
    } catch (const HelloError& e) {
        return {e.busy ? Kind::kNotNow : Kind::kNever, e.reason};
    } catch (const std::exception& e) {  // out of threads or memory, too: it may try again
        return {Kind::kNotNow, e.what()};
    }
    std::string why;
    try {
        why = worker->run();
    } catch (const std::exception& e) {  // out of memory: this link ends, the others continue
        why = e.what();
        worker->abort();
    }
    remove(id, *worker, dialled, why);
    switch (worker->answer()) {
        case WorkerAnswer::kAccepts: break;
        case WorkerAnswer::kRefuses: return {Kind::kNever, why};
        case WorkerAnswer::kBusy:
        case WorkerAnswer::kNone: return {Kind::kNotNow, why};
    }
    if (is_banned(for_bans(*worker, dialled)))
        return {};
    return {worker->heartbeat().done() > 0 ? Kind::kWorked : Kind::kNotNow, {}};
}

void Farm::dial(const sockets::Address& worker) {
    const std::lock_guard lock(m_mutex);
    if (m_stop)
        return;
    const std::optional<std::uint64_t> turn = m_dialled.add(worker.text());
    if (!turn)
        return;
    const auto run = [this, worker, turn = *turn] {
        dial_again_and_again(worker, turn);
        // An address that has been given up may be dialled again on request.
        const std::lock_guard own(m_mutex);
        m_dialled.remove(worker.text(), turn);
    };
    try {
        thread::add_thread(m_threads, "a worker that is dialled", run);
    } catch (...) {
        m_dialled.remove(worker.text());
        throw;
    }
}

void Farm::hang_up(const std::string& worker) {
    const std::lock_guard lock(m_mutex);
    m_dialled.remove(worker);
    m_wake.notify_all();
    for (const auto& [id, entry] : m_connected.workers) {
        if (m_stop || entry.dialled != worker)
            continue;
        // A goodbye blocks on a worker that does not read.
        const auto leave = [link = entry.link] {
            link->bye("it is not needed any more");
            link->abort();
        };
        try {
            thread::add_thread(m_threads, "a goodbye", leave);
        } catch (const std::exception&) {
            entry.link->abort();
        }
    }
}

std::vector<std::string> Farm::dialled() const {
    const std::lock_guard lock(m_mutex);
    return m_dialled.list();
}

void Farm::dial_again_and_again(const sockets::Address& address, std::uint64_t turn) {
    RedialPause pause(random_number());
    std::set<std::string> reported;  // reasons, since it last worked
    const auto report = [&](const std::string& why) {
        if (!why.empty() && reported.size() < kMaxReasons && reported.insert(why).second)
            util::log_warn("worker {}: {}; trying again", address.text(), why);
    };
    const auto stopped_after = [&](std::chrono::milliseconds time) {
        std::unique_lock lock(m_mutex);
        const auto is_over = [&] { return m_stop || !m_dialled.has(address.text(), turn); };
        return m_wake.wait_for(lock, time, is_over);
    };
    while (!stopped_after(std::chrono::milliseconds(0))) {
        try {
            auto link = net::dial(address, m_options.credentials, std::chrono::seconds(5));
            const LinkOutcome outcome = serve(std::move(link), address.text());
            if (outcome.kind == LinkOutcome::Kind::kNever) {
                if (!outcome.why.empty())
                    util::log_error("worker {} is left out: {}", address.text(), outcome.why);
                return;
            }
            if (outcome.kind == LinkOutcome::Kind::kNotNow) {
                report(outcome.why);
            } else {
                pause.reset();
                reported.clear();
            }
        } catch (const net::RefusedError& e) {
            util::log_error("{}", e.what());
            return;
        } catch (const std::exception& e) {
            report(e.what());
        }
        if (stopped_after(pause.next()))
            return;
    }
}

void Farm::watch() {
    std::unique_lock lock(m_mutex);
    while (!m_wake.wait_for(lock, farm_times().ping, [&] { return m_stop; })) {
        std::vector<std::shared_ptr<WorkerLink>> links;
        for (const auto& [id, entry] : m_connected.workers)
            links.push_back(entry.link);
        lock.unlock();
        for (const auto& link : links) {
            // This ends its reader, and its leases are returned.
            if (link->silent_for() > farm_times().silence) {
                util::log_warn("worker {} has been silent for too long", link->hello().name());
                link->abort();
            } else if (link->is_revoked()) {
                util::log_error("worker {} at {} is disconnected: its certificate is revoked",
                                link->hello().name(), link->peer());
                link->abort();
            } else {
                link->ping();
            }
        }
        links.clear();
        lock.lock();
    }
}

std::size_t Farm::workers() const {
    const std::lock_guard lock(m_mutex);
    return static_cast<std::size_t>(
        std::count_if(m_connected.workers.begin(), m_connected.workers.end(),
                      [](const auto& one) { return one.second.accepted; }));
}

std::vector<Farm::Worker> Farm::status() const {
    std::vector<Worker> out;
    const std::lock_guard lock(m_mutex);
    for (const auto& [id, entry] : m_connected.workers)
        if (entry.accepted)
            out.push_back({entry.member, entry.link->hello().name(), entry.link->peer(),
                           static_cast<int>(entry.link->hello().threads()), entry.link->latency_s(),
                           entry.link->heartbeat().memory_bytes(),
                           entry.link->traffic().received_bytes, entry.link->draining()});
    return out;
}

}  // namespace terravox::farm
