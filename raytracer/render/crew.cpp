#include "raytracer/render/crew.hpp"

#include <cstdio>
#include <random>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/open_files.hpp"
#include "common/util/resident_memory.hpp"
#include "common/util/version.hpp"
#include "raytracer/sched/green_processor.hpp"
#include "raytracer/sched/socket/hello.hpp"
#include "raytracer/sched/socket/tile_frames.hpp"
#include "raytracer/sched/thread_processor.hpp"

namespace terravox {

Crew::Crew(const CrewOptions& options, BlockManager& blocks, const BoxSource& source) : m_options(options), m_blocks(blocks) {
    if (m_options.threads == 0 && !m_options.green && !m_options.farm.any())
        throw UsageError("render: processing.threads = 0, and nobody else is there; allowed: 1 and more, or --worker, --listen, --discover, --green");
    if (!m_options.farm.any()) return;
    util::allow_many_open_files();
    m_farm = std::make_unique<Farm>(m_options.farm, blocks, source);
    m_farm->set_status_source([this] { return told_status(); });
}

Crew::~Crew() = default;

void Crew::render(const Scene& scene, const View& view, const std::function<void(TileProcessor&)>& work) {
    if (!m_farm && !m_options.green) {
        ThreadProcessor processor(view, m_blocks, m_options.threads);
        work(processor);
        processor.close();
        return;
    }
    PoolSettings settings;
    std::random_device device;
    settings.seed = std::uint64_t{device()} << 32 | device();
    settings.least_deadline = farm_times().least_deadline;
    settings.give_up = m_options.give_up;
    settings.make_checker = [&] { return std::make_shared<ThreadProcessor>(view, m_blocks, 1); };
    if (m_farm) settings.gone = [this](ProcessorPool::MemberId member, const std::string& why, bool expelled) { m_farm->gone(member, why, expelled); };
    ProcessorPool pool(std::move(settings));
    const std::string here = "this machine";
    if (m_options.threads > 0) pool.add({here, "threads", m_options.threads, true, false, std::make_shared<ThreadProcessor>(view, m_blocks, m_options.threads), {}});
    if (m_options.green) pool.add({here, "green", 1, true, true, std::make_shared<GreenProcessor>(view, m_blocks), {}});
    {
        const std::lock_guard lock(m_mutex);
        m_pool = &pool;
    }
    // However it ends, nobody may ask the pool once it is gone.
    const auto leave = [&] {
        auto last = hands();
        const std::lock_guard lock(m_mutex);
        m_last = std::move(last), m_last_counts = pool.counts();
        m_pool = nullptr;
        if (m_farm) m_farm->end();
    };
    try {
        if (m_farm) m_farm->begin(pool, scene, view);
        work(pool);
        pool.close();
    } catch (...) {
        leave();
        throw;
    }
    leave();
}

std::vector<Crew::Hand> Crew::hands() const {
    std::vector<Hand> out;
    {
        const std::lock_guard lock(m_mutex);
        if (m_pool == nullptr) return m_last;
        for (ProcessorPool::Status& status : m_pool->status()) out.push_back({std::move(status), {}, 0, 0});
    }
    for (Hand& hand : out)
        if (hand.status.kind != std::string_view("socket")) hand.memory_bytes = util::resident_bytes();
    if (!m_farm) return out;
    for (const Farm::Worker& worker : m_farm->status()) {
        const auto hand = std::find_if(out.begin(), out.end(), [&](const Hand& h) { return worker.member != 0 && h.status.id == worker.member; });
        if (hand != out.end()) hand->peer = worker.peer, hand->memory_bytes = worker.memory_bytes, hand->received_bytes = worker.received_bytes;
    }
    return out;
}

ProcessorPool::Counts Crew::counts() const {
    const std::lock_guard lock(m_mutex);
    return m_pool != nullptr ? m_pool->counts() : m_last_counts;
}

std::vector<std::string> Crew::table() const {
    if (!m_farm && !m_options.green) return {};
    std::vector<std::string> out;
    const auto line = [&](const char* format, auto... values) {
        char text[256];
        std::snprintf(text, sizeof text, format, values...);
        out.emplace_back(text);
    };
    line("  %-26s %-9s %7s %9s %10s %8s %8s %6s", "processor", "state", "threads", "tiles", "kpixel/s", "latency", "memory", "busy");
    for (const Hand& h : hands()) {
        const std::string name = (h.status.name + (h.status.kind == std::string_view("socket") ? "" : std::string(" (") + h.status.kind + ")")).substr(0, 26);
        line("  %-26s %-9s %7d %9llu %10.1f %5.1f ms %4llu MiB %4.0f %%", name.c_str(), h.status.state, h.status.threads, static_cast<unsigned long long>(h.status.bands),
             h.status.pixels_per_s / 1e3, h.status.latency_s * 1e3, static_cast<unsigned long long>(h.memory_bytes >> 20), 100 * h.status.busy_share);
    }
    return out;
}

farm::Status Crew::told_status() const {
    farm::Status out;
    out.set_role(farm::COORDINATOR);
    out.set_name(make_hello({}).name());
    out.set_software(std::string("terravox ") + kVersion);
    out.set_uptime_s(std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count());
    out.set_tiles_done(m_tiles_done), out.set_tiles_total(m_tiles);
    out.set_memory_bytes(util::resident_bytes());
    for (const Hand& h : hands()) {
        farm::Status::Member& m = *out.add_members();
        m.set_name(h.status.name), m.set_kind(h.status.kind), m.set_peer(h.peer), m.set_state(h.status.state);
        m.set_threads(static_cast<std::uint32_t>(h.status.threads)), m.set_tiles(h.status.bands), m.set_pixels(h.status.pixels);
        m.set_pixels_per_s(h.status.pixels_per_s), m.set_latency_s(h.status.latency_s), m.set_memory_bytes(h.memory_bytes), m.set_busy_share(h.status.busy_share);
        m.set_leases(static_cast<std::uint32_t>(h.status.leases));
    }
    return out;
}

}  // namespace terravox
