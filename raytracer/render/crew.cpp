#include "raytracer/render/crew.hpp"

#include <cstdio>
#include <random>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/open_files.hpp"
#include "common/util/printable.hpp"
#include "common/util/resident_memory.hpp"
#include "common/util/version.hpp"
#include "raytracer/farm/wire/hello.hpp"
#include "raytracer/farm/wire/tile_frames.hpp"
#include "raytracer/processors/green_processor.hpp"
#include "raytracer/processors/thread_processor.hpp"

namespace terravox {

/// The crew at one picture.
class Crew::Shift {
public:
    Shift(Crew& crew, const View& view) : m_crew(crew), m_view(view) {
        const CrewOptions& options = crew.m_options;
        if (!crew.m_farm && !options.green && !options.changes) {
            m_alone = std::make_unique<ThreadProcessor>(view, crew.m_blocks, options.threads);
            return;
        }
        PoolSettings settings;
        std::random_device device;
        settings.seed = std::uint64_t{device()} << 32 | device();
        settings.least_deadline = farm_times().least_deadline;
        settings.give_up = options.give_up;
        settings.make_checker = [this] {
            return std::make_shared<ThreadProcessor>(m_view, m_crew.m_blocks, 1);
        };
        settings.gone = [this](ProcessorPool::MemberId member, const std::string& why,
                               bool expelled) {
            if (m_crew.m_farm)
                m_crew.m_farm->gone(member, why, expelled);
        };
        m_pool = std::make_unique<ProcessorPool>(std::move(settings));
        add_threads();
        add_green();
        const std::lock_guard lock(crew.m_mutex);
        crew.m_shift = this;
    }
    ~Shift() {
        if (!m_pool)
            return;
        auto last = m_crew.hands();
        // However it ends, nobody may ask the pool once it is gone.
        const std::lock_guard lock(m_crew.m_mutex);
        m_crew.m_last = std::move(last), m_crew.m_last_counts = m_pool->counts();
        m_crew.m_shift = nullptr;
        if (m_crew.m_farm)
            m_crew.m_farm->end();
    }
    Shift(const Shift&) = delete;
    Shift& operator=(const Shift&) = delete;

    void join_farm() {
        if (m_pool && m_crew.m_farm)
            m_crew.m_farm->begin(*m_pool, m_view.scene, m_view);
    }
    void add_threads() {
        m_threads = m_crew.m_options.threads > 0
                        ? add("threads", m_crew.m_options.threads, false,
                              std::make_shared<ThreadProcessor>(m_view, m_crew.m_blocks,
                                                                m_crew.m_options.threads))
                        : 0;
    }
    void add_green() {
        m_green =
            m_crew.m_options.green
                ? add("green", 1, true, std::make_shared<GreenProcessor>(m_view, m_crew.m_blocks))
                : 0;
    }
    void remove_threads() { m_pool->remove(m_threads, "it is not needed any more"); }
    void remove_green() { m_pool->remove(m_green, "it is not needed any more"); }
    [[nodiscard]] TileProcessor& processor() noexcept {
        return m_alone ? static_cast<TileProcessor&>(*m_alone) : *m_pool;
    }
    [[nodiscard]] const ProcessorPool& pool() const noexcept { return *m_pool; }

private:
    ProcessorPool::MemberId add(const char* kind, int threads, bool on_caller,
                                std::shared_ptr<TileProcessor> processor) {
        return m_pool->add(
            {"this machine", kind, threads, true, on_caller, std::move(processor), {}});
    }
    Crew& m_crew;
    const View& m_view;
    std::unique_ptr<ThreadProcessor> m_alone;
    std::unique_ptr<ProcessorPool> m_pool;
    ProcessorPool::MemberId m_threads = 0, m_green = 0;
};

Crew::Crew(const CrewOptions& options, BlockManager& blocks, const BoxSource& source)
    : m_options(options), m_blocks(blocks), m_source(source) {
    if (m_options.threads == 0 && !m_options.green && !m_options.changes && !m_options.farm.any())
        throw UsageError(
            "render: processing.threads = 0, and nobody else is there; allowed: 1 and more, or "
            "--worker, --listen, --discover, --green");
    if (m_options.farm.any())
        open_farm();
}

Crew::~Crew() = default;

void Crew::open_farm() {
    util::allow_many_open_files();
    m_farm = std::make_unique<Farm>(m_options.farm, m_blocks, m_source);
    m_farm->set_status_source([this] { return told_status(); });
}

std::shared_ptr<TileProcessor> Crew::begin(const View& view) {
    const auto shift = std::make_shared<Shift>(*this, view);
    shift->join_farm();
    return {shift, &shift->processor()};
}

void Crew::set_threads(int threads) {
    if (threads == std::exchange(m_options.threads, threads) || m_shift == nullptr)
        return;
    m_shift->remove_threads();
    m_shift->add_threads();
}

void Crew::set_green(bool on) {
    if (on == std::exchange(m_options.green, on) || m_shift == nullptr)
        return;
    on ? m_shift->add_green() : m_shift->remove_green();
}

void Crew::dial(const net::Address& worker) {
    const net::Credentials& own = m_options.farm.credentials;
    if (own.token.empty() && !own.tls())
        throw UsageError("dial " + worker.text() +
                         ": no token; start with --token-file FILE, TERRAVOX_FARM_TOKEN in the "
                         "environment, or certificates");
    if (m_farm)
        return m_farm->dial(worker);
    m_options.farm.dial = {worker};
    open_farm();
    if (m_shift != nullptr)
        m_shift->join_farm();
}

void Crew::hang_up(const std::string& worker) {
    if (m_farm)
        m_farm->hang_up(worker);
}

std::vector<Crew::Hand> Crew::hands() const {
    std::vector<Hand> out;
    {
        const std::lock_guard lock(m_mutex);
        if (m_shift == nullptr)
            return m_last;
        for (ProcessorPool::Status& status : m_shift->pool().status())
            out.push_back({std::move(status), {}, 0, 0});
    }
    for (Hand& hand : out)
        if (hand.status.kind != std::string_view("socket"))
            hand.memory_bytes = util::resident_bytes();
    if (!m_farm)
        return out;
    for (const Farm::Worker& worker : m_farm->status()) {
        const auto hand = std::find_if(out.begin(), out.end(), [&](const Hand& h) {
            return worker.member != 0 && h.status.id == worker.member;
        });
        if (hand != out.end())
            hand->peer = worker.peer, hand->memory_bytes = worker.memory_bytes,
            hand->received_bytes = worker.received_bytes;
    }
    return out;
}

ProcessorPool::Counts Crew::counts() const {
    const std::lock_guard lock(m_mutex);
    return m_shift != nullptr ? m_shift->pool().counts() : m_last_counts;
}

std::vector<std::string> Crew::table() const {
    if (!m_farm && !m_options.green)
        return {};
    std::vector<std::string> out;
    const auto line = [&](const char* format, auto... values) {
        char text[256];
        std::snprintf(text, sizeof text, format, values...);
        out.emplace_back(text);
    };
    line("  %-26s %-9s %7s %9s %10s %8s %8s %6s", "processor", "state", "threads", "tiles",
         "kpixel/s", "latency", "memory", "busy");
    for (const Hand& h : hands()) {
        const std::string name =
            util::printable((h.status.name + (h.status.kind == std::string_view("socket")
                                                  ? ""
                                                  : std::string(" (") + h.status.kind + ")"))
                                .substr(0, 26));
        line("  %-26s %-9s %7d %9llu %10.1f %5.1f ms %4llu MiB %4.0f %%", name.c_str(),
             h.status.state, h.status.threads, static_cast<unsigned long long>(h.status.bands),
             h.status.pixels_per_s / 1e3, h.status.latency_s * 1e3,
             static_cast<unsigned long long>(h.memory_bytes >> 20), 100 * h.status.busy_share);
    }
    return out;
}

farm::Status Crew::told_status() const {
    farm::Status out;
    out.set_role(farm::COORDINATOR);
    out.set_name(make_hello({}).name());
    out.set_software(std::string("terravox ") + kVersion);
    out.set_uptime_s(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count());
    out.set_tiles_done(m_tiles_done), out.set_tiles_total(m_tiles);
    out.set_memory_bytes(util::resident_bytes());
    for (const Hand& h : hands()) {
        farm::Status::Member& m = *out.add_members();
        m.set_name(h.status.name), m.set_kind(h.status.kind), m.set_peer(h.peer),
            m.set_state(h.status.state);
        m.set_threads(static_cast<std::uint32_t>(h.status.threads)), m.set_tiles(h.status.bands),
            m.set_pixels(h.status.pixels);
        m.set_pixels_per_s(h.status.pixels_per_s), m.set_latency_s(h.status.latency_s),
            m.set_memory_bytes(h.memory_bytes), m.set_busy_share(h.status.busy_share);
        m.set_leases(static_cast<std::uint32_t>(h.status.leases));
    }
    return out;
}

}  // namespace terravox
