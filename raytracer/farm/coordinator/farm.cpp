#include "raytracer/farm/coordinator/farm.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <random>
#include <utility>

#include "common/thread/start_threads.hpp"
#include "raytracer/farm/wire/hello.hpp"
#include "raytracer/farm/wire/tile_frames.hpp"
#include "voxelserver/sockets/socket.hpp"

namespace terravox::farm {
namespace {

constexpr int kSupplierThreads = 3;
// False workers of one host, under any names: after that many, the host is no longer admitted.
constexpr int kMaxFalse = 3;

std::string host_of(const std::string& peer) {
    return peer.substr(0, peer.rfind(':'));
}

/// An identity that a worker cannot have many of; the name in its hello can be chosen freely.
/// Machines that share a certificate count as one, which only makes the pool more patient.
std::string who_is(const WorkerLink& worker) {
    const std::string& name = worker.certified_name();
    return name.empty() ? "host " + sockets::neighbourhood_of(worker.peer())
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
      m_supplier(blocks, random_number(), blocks.limit_bytes() / 4, kSupplierThreads) {
    if (m_options.listen)
        m_listener = std::make_unique<net::Listener>(
            *m_options.listen, m_options.credentials,
            [this](std::unique_ptr<net::Link> link) { (void)serve(std::move(link), ""); });
    if (m_listener)
        spdlog::info("waiting for workers on port {}", m_listener->port());
    if (m_options.discover)
        m_browser = std::make_unique<net::ServiceBrowser>(
            "worker", [this](net::ServiceBrowser::Event event, const net::FoundService& found) {
                if (event != net::ServiceBrowser::Event::kFound)
                    return;  // a working link must continue
                const sockets::Address address{found.address, found.port};
                spdlog::info("found worker {} at {}", found.name, address.text());
                dial(address);
            });
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

Farm::~Farm() {
    finish();
}

void Farm::finish() noexcept {
    m_browser.reset();
    end();
    std::vector<std::shared_ptr<WorkerLink>> links;
    {
        const std::lock_guard lock(m_mutex);
        m_stop = true;
        for (const auto& [id, place] : m_places)
            links.push_back(place.link);
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
    call.parcel = pack(scene, m_blocks.world_info());
    call.source = m_source;
    call.layers = view.wants_layers();
    const std::lock_guard lock(m_mutex);
    call.id = m_next_picture++;
    m_call = std::move(call);
    m_pool = &pool;
    for (auto& [id, place] : m_places)
        attach(place);
}

void Farm::end() {
    const std::lock_guard lock(m_mutex);
    m_pool = nullptr;
    m_call.reset();
    for (auto& [id, place] : m_places)
        place.member = 0;
}

void Farm::attach(Place& place) {
    if (m_pool == nullptr || place.link->draining())
        return;
    const farm::Hello& hello = place.link->hello();
    processors::ProcessorPool::Member member{hello.name(),
                                             "socket",
                                             static_cast<int>(hello.threads()),
                                             false,
                                             false,
                                             place.link->begin(*m_call),
                                             [link = place.link] { return link->latency_s(); }};
    member.paused = place.takes_nothing();
    member.who = who_is(*place.link);
    const auto processor = member.processor;
    try {
        place.member = m_pool->add(std::move(member));
    } catch (const std::exception& e) {  // out of threads or memory: the others continue
        spdlog::error("worker {} is left out of the picture: {}", hello.name(), e.what());
        processor->cancel();
    }
}

void Farm::gone(processors::ProcessorPool::MemberId member, const std::string& why, bool expelled) {
    std::shared_ptr<WorkerLink> link;
    {
        const std::lock_guard lock(m_mutex);
        for (auto& [id, place] : m_places)
            if (place.member == member) {
                link = place.link;
                place.member = 0;
                if (expelled)
                    ban(*link, place.dialled);
            }
    }
    if (!link)
        return;
    if (expelled) {
        spdlog::error("worker {} at {} is expelled: {}", link->hello().name(), link->peer(), why);
        link->refuse_it("expelled: " + why);
    } else if (link->draining()) {
        spdlog::info("worker {} has left", link->hello().name());
    } else {
        spdlog::warn("worker {} at {} is lost: {}", link->hello().name(), link->peer(), why);
    }
}

bool Farm::is_banned(const std::string& name, const std::string& peer,
                     const std::string& dialled) const {
    const std::lock_guard lock(m_mutex);
    if (!dialled.empty())
        return m_banned.contains(dialled);
    const auto host = m_banned_of_host.find(host_of(peer));
    return host != m_banned_of_host.end() &&
           (host->second >= kMaxFalse || m_banned.contains(name + " of " + host->first));
}

// The lock must be held.
void Farm::ban(const WorkerLink& worker, const std::string& dialled) {
    const std::string host = host_of(worker.peer());
    if (m_banned.insert(dialled.empty() ? worker.hello().name() + " of " + host : dialled).second &&
        dialled.empty())
        ++m_banned_of_host[host];
}

bool Farm::pause(const std::string& worker, bool on) {
    const std::lock_guard lock(m_mutex);
    bool found = false;
    for (auto& [id, place] : m_places) {
        if (!worker.empty() && place.link->hello().name() != worker)
            continue;
        place.paused = on;
        found = true;
        if (m_pool != nullptr && place.member != 0)
            m_pool->pause(place.member, place.takes_nothing());
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

bool Farm::serve(std::unique_ptr<net::Link> link, const std::string& dialled) {
    std::shared_ptr<WorkerLink> worker;
    std::uint64_t id = 0;
    try {
        farm::Hello hello =
            meet(*link, make_hello({}),
                 dialled.empty() ? std::initializer_list<farm::Role>{farm::WORKER, farm::OBSERVER}
                                 : std::initializer_list<farm::Role>{farm::WORKER});
        if (hello.role() == farm::OBSERVER) {
            observe(*link);
            return false;
        }
        if (is_banned(hello.name(), link->peer(), dialled)) {
            refuse(*link, "expelled before");
            return false;
        }
        const std::lock_guard lock(m_mutex);
        if (m_stop || (!dialled.empty() && !m_dialled.contains(dialled)))
            return false;  // it was sent away before it was registered
        id = m_next_place++;
        // Calls `act` with the lock held, if the worker is assigned to a pool.
        const auto with_place = [this, id](const auto& act) {
            const std::lock_guard own(m_mutex);
            const auto place = m_places.find(id);
            if (place != m_places.end() && place->second.member != 0 && m_pool != nullptr)
                act(place->second);
        };
        WorkerLink::Reported reported;
        reported.drains = [this, with_place](const std::vector<tiles::RenderTile>& given_back) {
            with_place([&](Place& place) { m_pool->drain(place.member, given_back); });
        };
        reported.pauses = [this, with_place](bool) {
            with_place([&](Place& place) { m_pool->pause(place.member, place.takes_nothing()); });
        };
        spdlog::info("worker {} at {}: {} threads, {}", hello.name(), link->peer(), hello.threads(),
                     hello.cpu_features());
        worker = std::make_shared<WorkerLink>(std::move(link), std::move(hello), m_supplier,
                                              std::move(reported));
        attach(m_places.emplace(id, Place{worker, dialled}).first->second);
    } catch (const HelloError& e) {
        spdlog::log(e.busy ? spdlog::level::info : spdlog::level::warn, "{}", e.what());
        return e.busy || dialled.empty();
    } catch (const std::exception& e) {  // out of threads or memory, too: it may try again
        spdlog::warn("{}", e.what());
        const std::lock_guard lock(m_mutex);
        m_places.erase(id);
        return true;
    }
    std::string why;
    try {
        why = worker->run();
    } catch (const std::exception& e) {  // out of memory: this link ends, the others continue
        why = e.what();
        worker->abort();
    }
    processors::ProcessorPool* pool = nullptr;
    processors::ProcessorPool::MemberId member = 0;
    {
        const std::lock_guard lock(m_mutex);
        const auto place = m_places.find(id);
        member = place->second.member;
        pool = m_pool;
        m_places.erase(place);
        if (worker->misbehaved())
            ban(*worker, dialled);
    }
    if (member != 0 && pool != nullptr) {
        if (worker->misbehaved())
            spdlog::error("worker {} at {} is expelled: {}", worker->hello().name(), worker->peer(),
                          why);
        else if (worker->draining())
            spdlog::info("worker {} has left", worker->hello().name());
        else
            spdlog::warn("worker {} at {} is lost: {}", worker->hello().name(), worker->peer(),
                         why);
    }
    return !is_banned(worker->hello().name(), worker->peer(), dialled);
}

void Farm::dial(const sockets::Address& worker) {
    const std::lock_guard lock(m_mutex);
    if (m_stop || !m_dialled.try_emplace(worker.text(), m_next_turn).second)
        return;
    const auto run = [this, worker, turn = m_next_turn++] {
        dial_again_and_again(worker, turn);
        // An address that has been given up may be dialled again on request.
        const std::lock_guard own(m_mutex);
        const auto found = m_dialled.find(worker.text());
        if (found != m_dialled.end() && found->second == turn)
            m_dialled.erase(found);
    };
    try {
        thread::add_thread(m_threads, "a worker that is dialled", run);
    } catch (...) {
        m_dialled.erase(worker.text());
        throw;
    }
}

void Farm::hang_up(const std::string& worker) {
    const std::lock_guard lock(m_mutex);
    m_dialled.erase(worker);
    m_wake.notify_all();
    for (const auto& [id, place] : m_places) {
        if (m_stop || place.dialled != worker)
            continue;
        // A goodbye blocks on a worker that does not read.
        const auto leave = [link = place.link] {
            link->bye("it is not needed any more");
            link->abort();
        };
        try {
            thread::add_thread(m_threads, "a goodbye", leave);
        } catch (const std::exception&) {
            place.link->abort();
        }
    }
}

std::vector<std::string> Farm::dialled() const {
    const std::lock_guard lock(m_mutex);
    std::vector<std::string> out;
    for (const auto& [address, turn] : m_dialled)
        out.push_back(address);
    return out;
}

void Farm::dial_again_and_again(const sockets::Address& address, std::uint64_t turn) {
    auto pause = farm_times().redial;
    bool reported = false;
    const auto stopped_after = [&](std::chrono::milliseconds time) {
        std::unique_lock lock(m_mutex);
        const auto is_over = [&] {
            const auto found = m_dialled.find(address.text());
            return m_stop || found == m_dialled.end() || found->second != turn;
        };
        return m_wake.wait_for(lock, time, is_over);
    };
    while (!stopped_after(std::chrono::milliseconds(0))) {
        try {
            auto link = net::dial(address, m_options.credentials, std::chrono::seconds(5));
            pause = farm_times().redial;
            reported = false;
            if (!serve(std::move(link), address.text()))
                return;
        } catch (const net::RefusedError& e) {
            spdlog::error("{}", e.what());
            return;
        } catch (const std::exception& e) {
            if (!std::exchange(reported, true))
                spdlog::warn("{}; trying again", e.what());
        }
        if (stopped_after(pause))
            return;
        pause = std::min(pause * 2, farm_times().max_redial);
    }
}

void Farm::watch() {
    std::unique_lock lock(m_mutex);
    while (!m_wake.wait_for(lock, farm_times().ping, [&] { return m_stop; })) {
        std::vector<std::shared_ptr<WorkerLink>> links;
        for (const auto& [id, place] : m_places)
            links.push_back(place.link);
        lock.unlock();
        for (const auto& link : links) {
            // This ends its reader, and its leases are returned.
            if (link->silent_for() > farm_times().silence) {
                spdlog::warn("worker {} has been silent for too long", link->hello().name());
                link->abort();
            } else if (link->is_revoked()) {
                spdlog::error("worker {} at {} is sent away: its certificate is revoked",
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
    return m_places.size();
}

std::vector<Farm::Worker> Farm::status() const {
    std::vector<Worker> out;
    const std::lock_guard lock(m_mutex);
    for (const auto& [id, place] : m_places)
        out.push_back({place.member, place.link->hello().name(), place.link->peer(),
                       static_cast<int>(place.link->hello().threads()), place.link->latency_s(),
                       place.link->heartbeat().memory_bytes(), place.link->traffic().received_bytes,
                       place.link->draining()});
    return out;
}

}  // namespace terravox::farm
