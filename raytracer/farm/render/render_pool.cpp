#include "raytracer/farm/render/render_pool.hpp"

#include <random>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/process_memory.hpp"
#include "common/util/text.hpp"
#include "common/util/version.hpp"
#include "raytracer/farm/processors/green_processor.hpp"
#include "raytracer/farm/processors/thread_processor.hpp"
#include "raytracer/farm/wire/frames.hpp"

namespace terravox::render {

/// The render pool while it renders one picture.
class RenderPool::PictureSession {
public:
    PictureSession(RenderPool& render_pool, const shade::View& view)
        : m_render_pool(render_pool), m_view(view) {
        const RenderPoolOptions& options = render_pool.m_options;
        if (!render_pool.m_farm && !options.green && !options.changes) {
            m_alone = std::make_unique<processors::ThreadProcessor>(view, render_pool.m_blocks,
                                                                    options.threads);
            return;
        }
        processors::PoolSettings settings;
        std::random_device device;
        settings.seed = std::uint64_t{device()} << 32 | device();
        settings.min_deadline = farm::farm_times().min_deadline;
        settings.give_up = options.give_up;
        settings.make_checker = [this] {
            return std::make_shared<processors::ThreadProcessor>(m_view, m_render_pool.m_blocks, 1);
        };
        settings.gone = [this](processors::ProcessorPool::MemberId member, const std::string& why,
                               bool expelled) {
            if (m_render_pool.m_farm)
                m_render_pool.m_farm->gone(member, why, expelled);
        };
        m_pool = std::make_unique<processors::ProcessorPool>(std::move(settings));
        add_threads();
        add_green();
        const std::lock_guard lock(render_pool.m_mutex);
        render_pool.m_session = this;
    }
    ~PictureSession() {
        if (!m_pool)
            return;
        auto last = m_render_pool.participants();
        // However the picture ends, no thread may use the pool after it is destroyed.
        const std::lock_guard lock(m_render_pool.m_mutex);
        m_render_pool.m_last = std::move(last);
        m_render_pool.m_last_counts = m_pool->counts();
        m_render_pool.m_session = nullptr;
        if (m_render_pool.m_farm)
            m_render_pool.m_farm->end();
    }

    void join_farm() {
        if (m_pool && m_render_pool.m_farm)
            m_render_pool.m_farm->begin(*m_pool, m_view.scene, m_view);
    }
    void add_threads() {
        m_threads = m_render_pool.m_options.threads > 0
                        ? add("threads", m_render_pool.m_options.threads, false,
                              std::make_shared<processors::ThreadProcessor>(
                                  m_view, m_render_pool.m_blocks, m_render_pool.m_options.threads))
                        : 0;
    }
    void add_green() {
        m_green =
            m_render_pool.m_options.green
                ? add("green", 1, true,
                      std::make_shared<processors::GreenProcessor>(m_view, m_render_pool.m_blocks))
                : 0;
    }
    void remove_threads() { m_pool->remove(m_threads, "it is not needed any more"); }
    void remove_green() { m_pool->remove(m_green, "it is not needed any more"); }
    [[nodiscard]] processors::TileProcessor& processor() noexcept {
        return m_alone ? static_cast<processors::TileProcessor&>(*m_alone) : *m_pool;
    }
    [[nodiscard]] const processors::ProcessorPool& pool() const noexcept { return *m_pool; }

private:
    processors::ProcessorPool::MemberId add(const char* kind, int threads, bool on_caller,
                                            std::shared_ptr<processors::TileProcessor> processor) {
        return m_pool->add(
            {"this machine", kind, threads, true, on_caller, std::move(processor), {}});
    }
    RenderPool& m_render_pool;
    const shade::View& m_view;
    std::unique_ptr<processors::ThreadProcessor> m_alone;
    std::unique_ptr<processors::ProcessorPool> m_pool;
    processors::ProcessorPool::MemberId m_threads = 0;
    processors::ProcessorPool::MemberId m_green = 0;
};

RenderPool::RenderPool(const RenderPoolOptions& options, blocks::BlockManager& blocks,
                       const farm::BoxSource& source)
    : m_options(options), m_blocks(blocks), m_source(source) {
    if (m_options.threads == 0 && !m_options.green && !m_options.changes && !m_options.farm.any())
        throw util::UsageError(
            "render: processing.threads = 0, and there is no worker; allowed: 1 and more, or "
            "--worker, --listen, --green");
    if (m_options.farm.any())
        open_farm();
}

RenderPool::~RenderPool() = default;

void RenderPool::open_farm() {
    util::raise_open_file_limit();
    m_farm = std::make_unique<farm::Farm>(m_options.farm, m_blocks, m_source);
    m_farm->set_status_source([this] { return reported_status(); });
}

std::shared_ptr<processors::TileProcessor> RenderPool::begin(const shade::View& view) {
    const auto shift = std::make_shared<PictureSession>(*this, view);
    shift->join_farm();
    return {shift, &shift->processor()};
}

void RenderPool::set_threads(int threads) {
    if (threads == std::exchange(m_options.threads, threads) || m_session == nullptr)
        return;
    m_session->remove_threads();
    m_session->add_threads();
}

void RenderPool::set_green(bool on) {
    if (on == std::exchange(m_options.green, on) || m_session == nullptr)
        return;
    on ? m_session->add_green() : m_session->remove_green();
}

void RenderPool::dial(const sockets::Address& worker) {
    const net::Credentials& own = m_options.farm.credentials;
    if (own.token.empty() && !own.tls())
        throw util::UsageError(
            "dial " + worker.text() +
            ": no token; start with --token-file FILE, TERRAVOX_FARM_TOKEN in the "
            "environment, or certificates");
    if (m_farm)
        return m_farm->dial(worker);
    m_options.farm.dial = {worker};
    open_farm();
    if (m_session != nullptr)
        m_session->join_farm();
}

void RenderPool::hang_up(const std::string& worker) {
    if (m_farm)
        m_farm->hang_up(worker);
}

std::vector<RenderPool::Participant> RenderPool::participants() const {
    std::vector<Participant> out;
    {
        const std::lock_guard lock(m_mutex);
        if (m_session == nullptr)
            return m_last;
        for (processors::ProcessorPool::Status& status : m_session->pool().status())
            out.push_back({std::move(status), {}, 0, 0});
    }
    for (Participant& participant : out)
        if (participant.status.kind != std::string_view("socket"))
            participant.memory_bytes = util::resident_bytes();
    if (!m_farm)
        return out;
    for (const farm::Farm::Worker& worker : m_farm->status()) {
        const auto participant = std::find_if(out.begin(), out.end(), [&](const Participant& h) {
            return worker.member != 0 && h.status.id == worker.member;
        });
        if (participant != out.end()) {
            participant->peer = worker.peer;
            participant->memory_bytes = worker.memory_bytes;
            participant->received_bytes = worker.received_bytes;
        }
    }
    return out;
}

processors::ProcessorPool::Counts RenderPool::counts() const {
    const std::lock_guard lock(m_mutex);
    return m_session != nullptr ? m_session->pool().counts() : m_last_counts;
}

std::vector<std::string> RenderPool::table() const {
    if (!m_farm && !m_options.green)
        return {};
    std::vector<std::string> out;
    out.push_back(fmt::format("  {:<26} {:<9} {:>7} {:>9} {:>10} {:>8} {:>8} {:>6}", "processor",
                              "state", "threads", "tiles", "kpixel/s", "latency", "memory",
                              "busy"));
    for (const Participant& h : participants()) {
        const std::string name =
            util::printable((h.status.name + (h.status.kind == std::string_view("socket")
                                                  ? ""
                                                  : std::string(" (") + h.status.kind + ")"))
                                .substr(0, 26));
        out.push_back(fmt::format("  {:<26} {:<9} {:7} {:9} {:10.1f} {:5.1f} ms {:4} MiB {:4.0f} %",
                                  name, h.status.state, h.status.threads, h.status.bands,
                                  h.status.pixels_per_s / 1e3, h.status.latency_s * 1e3,
                                  h.memory_bytes >> 20, 100 * h.status.busy_share));
    }
    return out;
}

farm::Status RenderPool::reported_status() const {
    farm::Status out;
    out.set_role(farm::COORDINATOR);
    out.set_name(farm::make_hello({}).name());
    out.set_software(std::string("terravox ") + kVersion);
    out.set_uptime_s(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count());
    out.set_tiles_done(m_tiles_done);
    out.set_tiles_total(m_tiles);
    out.set_memory_bytes(util::resident_bytes());
    for (const Participant& h : participants()) {
        farm::Status::Member& m = *out.add_members();
        m.set_name(h.status.name);
        m.set_kind(h.status.kind);
        m.set_peer(h.peer);
        m.set_state(h.status.state);
        m.set_threads(static_cast<std::uint32_t>(h.status.threads));
        m.set_tiles(h.status.bands);
        m.set_pixels(h.status.pixels);
        m.set_pixels_per_s(h.status.pixels_per_s);
        m.set_latency_s(h.status.latency_s);
        m.set_memory_bytes(h.memory_bytes);
        m.set_busy_share(h.status.busy_share);
        m.set_leases(static_cast<std::uint32_t>(h.status.leases));
    }
    return out;
}

}  // namespace terravox::render
