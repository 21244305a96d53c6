#include "raytracer/farm/worker/worker_session.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "common/thread/start_threads.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/process_memory.hpp"
#include "raytracer/core/tiles/tile_codec.hpp"
#include "raytracer/farm/wire/frames.hpp"

namespace terravox::farm {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kMaxStates_bytes = std::size_t{16} << 20;
// Of a scene, its materials or its world: in practice some kilobytes.
constexpr std::size_t kMaxText_bytes = std::size_t{1} << 20;
constexpr std::size_t kMaxOld = 16;  // pictures that have ended, and whose threads have not
constexpr int kMaxOldWorlds = 1;     // of those, which each keep boxes in memory
constexpr int kMaxEdge_px = 65'536;

std::int64_t now_ns() noexcept {
    return std::chrono::steady_clock::now().time_since_epoch().count();
}

/// What is wrong with a tile that a coordinator requests; empty: nothing. The scene's size need not
/// be checked: the tracer can trace any point of the picture's plane.
std::string describe_fault(const tiles::RenderTile& t) {
    const auto within = [](int a, int b) { return a >= 0 && a < b && b <= kMaxEdge_px; };
    if (!within(t.x0, t.x1) || !within(t.y0, t.y1))
        return "a tile beyond any picture";
    if (t.step < 1 || t.step > 64 || !std::has_single_bit(static_cast<unsigned>(t.step)))
        return "a tile with step " + std::to_string(t.step);
    if (t.samples > 65'536 || t.first_sample > (1U << 24))
        return "a tile of " + std::to_string(t.samples) + " samples from " +
               std::to_string(t.first_sample);
    return {};
}

}  // namespace

WorkerSession::WorkerSession(std::unique_ptr<net::Link> link, std::string coordinator,
                             SessionOptions options, WorkerShared& shared)
    : m_link(std::move(link)),
      m_coordinator(std::move(coordinator)),
      m_options(std::move(options)),
      m_shared(shared),
      m_heard_ns(now_ns()) {}

WorkerSession::End WorkerSession::run(std::string& why) {
    std::exception_ptr beat_failure;
    std::thread heart = thread::start_thread("heartbeats", [this, &beat_failure] {
        try {
            beat();
        } catch (...) {
            // Without heartbeats the coordinator considers this worker lost: the session ends here,
            // too, instead of the program.
            beat_failure = std::current_exception();
            m_link->abort();
        }
    });
    std::string wrong;
    std::exception_ptr failure;
    try {
        while (auto frame = m_link->receive()) {
            m_heard_ns = now_ns();
            wrong = take(*frame);
            if (!wrong.empty() || m_end)
                break;
        }
    } catch (...) {
        failure = std::current_exception();
    }
    const std::string ended = m_link->why_ended();
    if (!wrong.empty())
        why = "it sent " + wrong;
    else if (!m_end)
        why = ended.empty() ? "the link ended" : ended;
    m_link->abort();
    {
        const std::lock_guard lock(m_mutex);
        m_over = true;
    }
    m_wake.notify_all();
    heart.join();
    if (!failure)
        failure = beat_failure;
    if (m_world)
        m_world->stop();
    end_picture();
    for (const auto& old : m_old)
        old->end();
    m_old.clear();
    if (failure)
        std::rethrow_exception(failure);
    if (m_availability.draining && wrong.empty())
        return End::kDrained;
    return m_end.value_or(End::kLost);
}

std::shared_ptr<PictureContext> WorkerSession::current() const {
    const std::lock_guard lock(m_mutex);
    return m_context;
}

std::string WorkerSession::take_text(const farm::State& state) {
    const std::string& text = state.content();
    const std::string& hash = state.hash();
    if (text.size() > kMaxText_bytes)
        return "a text of " + std::to_string(text.size()) + " bytes; allowed: up to " +
               std::to_string(kMaxText_bytes);
    if (state_hash(text) != hash)
        return "a text that does not match its hash";
    // Else the text is one of a picture that has ended meanwhile.
    if (!m_awaited.picture ||
        (hash != m_awaited.picture->scene() && hash != m_awaited.picture->materials() &&
         hash != m_awaited.picture->world()))
        return {};
    {
        const std::lock_guard lock(m_shared.mutex);
        std::size_t bytes = text.size();
        for (const auto& [known, content] : m_shared.states)
            bytes += content.size();
        if (bytes > kMaxStates_bytes)
            m_shared.states.clear();
        m_shared.states[hash] = text;
    }
    m_awaited.texts[hash] = text;
    return begin_picture_if_complete();
}

void WorkerSession::take_stop(const farm::Stop& stop) {
    const bool whole_picture = stop.ids_size() == 0;
    if (whole_picture && m_awaited.picture && m_awaited.picture->id() == stop.picture()) {
        m_awaited.picture.reset();
        m_awaited.early.clear();
    }
    const std::shared_ptr<PictureContext> context = current();
    if (!context || context->picture() != stop.picture())
        return;
    if (whole_picture)
        end_picture();
    else
        context->drop({stop.ids().begin(), stop.ids().end()});
}

std::string WorkerSession::take(const farm::Frame& frame) {
    switch (frame.what_case()) {
        case farm::Frame::kPing: {
            farm::Frame pong;
            pong.mutable_pong()->set_stamp(frame.ping().stamp());
            (void)m_link->send(std::move(pong));
            return {};
        }
        case farm::Frame::kPong: return {};
        case farm::Frame::kBye: m_end = End::kBye; return {};
        case farm::Frame::kRefusal:
            util::log_error("{} refuses this worker: {}", m_coordinator,
                            frame.refusal().reason().substr(0, 400));
            m_end = End::kRefused;
            return {};
        case farm::Frame::kPicture: return begin_picture(frame.picture());
        case farm::Frame::kState: return take_text(frame.state());
        case farm::Frame::kTask: return add_task(frame.task());
        case farm::Frame::kStop: take_stop(frame.stop()); return {};
        case farm::Frame::kBox:
            if (m_world && !m_world->coordinator->on_reply(frame.box()))
                return "a box that was not requested";
            return {};
        default:
            return "a frame that no coordinator sends (" +
                   std::to_string(static_cast<int>(frame.what_case())) + ")";
    }
}

std::string WorkerSession::begin_picture(const farm::Picture& picture) {
    end_picture();
    m_awaited.early.clear();
    m_awaited.texts.clear();
    m_awaited.early_tiles = 0;
    if (m_old.size() > kMaxOld)
        return "pictures faster than any can end";
    m_awaited.picture = picture;
    for (const std::string* hash : {&picture.scene(), &picture.materials(), &picture.world()}) {
        if (hash->size() != 16)
            return "a picture without the hashes of its texts";
        {
            const std::lock_guard lock(m_shared.mutex);
            if (const auto found = m_shared.states.find(*hash); found != m_shared.states.end()) {
                m_awaited.texts[*hash] = found->second;
                continue;
            }
        }
        farm::Frame frame;
        frame.mutable_need_state()->set_hash(*hash);
        (void)m_link->send(std::move(frame));
    }
    return begin_picture_if_complete();
}

std::optional<PictureSpec> WorkerSession::arrived_spec() const {
    const auto get = [&](const std::string& hash, std::string& into) {
        const auto found = m_awaited.texts.find(hash);
        if (found != m_awaited.texts.end())
            into = found->second;
        return found != m_awaited.texts.end();
    };
    PictureSpec out;
    if (!m_awaited.picture || !get(m_awaited.picture->scene(), out.scene) ||
        !get(m_awaited.picture->materials(), out.materials) ||
        !get(m_awaited.picture->world(), out.world))
        return std::nullopt;
    return out;
}

std::string WorkerSession::enter_world(const farm::Picture& picture, const std::string& world) {
    if (m_world && m_world->world_id == picture.world_id() && m_world->info_text == world &&
        m_world->server == picture.server() && m_world->generated == picture.generated())
        return {};
    voxel::WorldInfo info;
    try {
        info = unpack_world(world);
    } catch (const util::Error& e) {
        return std::string("an invalid world: ") + e.what();
    }
    if (m_world)
        m_world->stop();
    const auto is_elsewhere = [&](const auto& old) {
        return &old->world() != m_world.get() && !old->is_over();
    };
    if (std::count_if(m_old.begin(), m_old.end(), is_elsewhere) > kMaxOldWorlds)
        return "worlds faster than any can end";
    m_world = std::make_shared<WorkerWorld>();
    m_world->world_id = picture.world_id();
    m_world->info_text = world;
    m_world->server = picture.server();
    m_world->generated = picture.generated();
    m_world->http = m_options.http;
    m_world->coordinator = std::make_unique<CoordinatorWorld>(
        std::move(info), picture.world_id(),
        [this](farm::Frame frame) {
            ++m_shared.box_requests;
            return m_link->send(std::move(frame));
        },
        m_shared.shelf);
    return {};
}

void WorkerSession::send_done(std::uint64_t picture, std::uint64_t lease,
                              const tiles::TileResult& result) {
    const std::vector<std::byte> bytes = tiles::encode_tile(result);
    m_shared.pixels += result.samples.size();
    m_shared.rays += result.counts.all_rays();
    m_shared.result_bytes += bytes.size();
    double seconds = 0;
    for (const double s : result.counts.seconds)
        seconds += s;
    m_shared.busy_us += static_cast<std::uint64_t>(seconds * 1e6);
    ++m_shared.tiles;
    ++m_rendered.tiles;
    m_rendered.pixels += result.samples.size();
    farm::Frame frame;
    frame.mutable_done()->set_picture(picture);
    frame.mutable_done()->set_id(lease);
    frame.mutable_done()->set_result(bytes.data(), bytes.size());
    (void)m_link->send(std::move(frame));
}

void WorkerSession::send_failed(std::uint64_t picture, std::uint64_t lease,
                                const std::string& reason) {
    ++m_shared.failed;
    util::log_error("a {} of {} cannot be rendered here: {}", lease == 0 ? "picture" : "tile",
                    m_coordinator, reason);
    farm::Frame frame;
    frame.mutable_failed()->set_picture(picture);
    frame.mutable_failed()->set_id(lease);
    frame.mutable_failed()->set_reason(reason);
    (void)m_link->send(std::move(frame));
}

std::string WorkerSession::begin_picture_if_complete() {
    std::optional<PictureSpec> spec = arrived_spec();
    if (!spec)
        return {};
    const farm::Picture picture = *std::exchange(m_awaited.picture, std::nullopt);
    if (std::string wrong = enter_world(picture, spec->world); !wrong.empty())
        return wrong;
    PictureContext::Answers answers;
    answers.done = [this, id = picture.id()](std::uint64_t lease, const tiles::TileResult& result) {
        send_done(id, lease, result);
    };
    answers.failed = [this, id = picture.id()](std::uint64_t lease, const std::string& reason) {
        send_failed(id, lease, reason);
    };
    std::shared_ptr<PictureContext> context;
    try {
        context = std::make_shared<PictureContext>(picture.id(), *std::move(spec), m_world,
                                                   m_options.threads, m_options.memory_bytes,
                                                   std::move(answers));
    } catch (const util::Error& e) {
        m_awaited.early.clear();
        send_failed(picture.id(), 0, e.what());
        return {};
    }
    {
        const std::lock_guard lock(m_mutex);
        m_context = std::move(context);
    }
    for (const farm::Task& task : std::exchange(m_awaited.early, {}))
        if (std::string wrong = add_task(task); !wrong.empty())
            return wrong;
    return {};
}

std::string WorkerSession::add_task(const farm::Task& task) {
    std::vector<std::uint64_t> refused;
    if (m_awaited.picture && m_awaited.picture->id() == task.picture()) {
        m_awaited.early_tiles += static_cast<std::size_t>(task.tiles_size());
        if (m_awaited.early_tiles > PictureContext::kMaxWaiting ||
            m_awaited.early.size() >= PictureContext::kMaxWaiting)
            return "more tiles than it may";
        m_awaited.early.push_back(task);
        return {};
    }
    const std::shared_ptr<PictureContext> context = current();
    if (!context || context->picture() != task.picture())
        return {};  // of a picture that has ended
    if (context->load().waiting + static_cast<std::size_t>(task.tiles_size()) >
        PictureContext::kMaxWaiting)
        return "more tiles than it may";
    for (const farm::Tile& t : task.tiles()) {
        const tiles::RenderTile tile = from_frame(t);
        if (std::string fault = describe_fault(tile); !fault.empty())
            return fault;
        if (m_availability.draining)
            refused.push_back(t.id());
        else
            context->add(t.id(), tile);
    }
    give_back(refused);
    return {};
}

void WorkerSession::end_picture() {
    std::shared_ptr<PictureContext> context;
    {
        const std::lock_guard lock(m_mutex);
        context = std::exchange(m_context, nullptr);
    }
    std::erase_if(m_old, [](const auto& old) { return old->is_over(); });
    if (!context)
        return;
    context->cancel();
    m_old.push_back(std::move(context));  // the reader does not wait for its threads
}

void WorkerSession::give_back(const std::vector<std::uint64_t>& ids) {
    if (ids.empty())
        return;
    farm::Frame frame;
    for (const std::uint64_t id : ids)
        frame.mutable_drain()->add_given_back(id);
    (void)m_link->send(std::move(frame));
}

void WorkerSession::drain(milliseconds timeout) {
    const auto until = std::chrono::steady_clock::now() + timeout;
    if (m_availability.draining.exchange(true))
        return;
    const std::shared_ptr<PictureContext> context = current();
    farm::Frame frame;
    farm::Drain& drain = *frame.mutable_drain();
    if (context)
        for (const std::uint64_t id : context->drop_all())
            drain.add_given_back(id);
    (void)m_link->send(std::move(frame));
    if (context && !context->wait_idle(until))
        util::log_warn("tiles under way are given up: they take longer than {} ms",
                       timeout.count());
    farm::Frame bye;
    bye.mutable_bye()->set_reason("drained");
    (void)m_link->send(std::move(bye));
    m_link->close();
}

void WorkerSession::pause(bool on) {
    m_availability.paused = on;
    farm::Frame frame;
    *frame.mutable_heartbeat() = heartbeat();
    (void)m_link->send(std::move(frame));
}

farm::Heartbeat WorkerSession::heartbeat() const {
    farm::Heartbeat out;
    const Status now = status();
    out.set_memory_bytes(util::resident_bytes());
    out.set_box_bytes(now.box_bytes);
    out.set_waiting(static_cast<std::uint32_t>(now.waiting));
    out.set_begun(static_cast<std::uint32_t>(now.begun));
    out.set_done(now.tiles);
    out.set_paused(m_availability.paused);
    return out;
}

void WorkerSession::beat() {
    std::uint64_t received_bytes = 0;
    std::unique_lock lock(m_mutex);
    // The first one at once: it tells the coordinator that this worker has taken it on.
    for (auto pause = milliseconds(0); !m_wake.wait_for(lock, pause, [&] { return m_over; });
         pause = farm_times().heartbeat) {
        lock.unlock();
        const net::Link::Traffic traffic = m_link->traffic();
        if (std::exchange(received_bytes, traffic.received_bytes) != traffic.received_bytes)
            m_heard_ns = now_ns();  // a large frame arrives piece by piece
        if (std::chrono::nanoseconds(now_ns() - m_heard_ns) > farm_times().silence) {
            util::log_warn("{} has been silent for too long", m_coordinator);
            m_link->abort();
        }
        if (m_link->is_revoked()) {
            util::log_error("{} at {} is left: its certificate is revoked", m_coordinator,
                            m_link->peer());
            m_link->abort();
        }
        if (traffic.queued_bytes <= net::kMaxBeforePing_bytes) {
            farm::Frame frame;
            *frame.mutable_heartbeat() = heartbeat();
            (void)m_link->send(std::move(frame));
        }
        lock.lock();
    }
}

const char* WorkerSession::find_state(bool has_picture) const noexcept {
    if (m_availability.draining)
        return "draining";
    if (m_availability.paused)
        return "paused";
    return has_picture ? "working" : "waiting";
}

WorkerSession::Status WorkerSession::status() const {
    Status out;
    const std::shared_ptr<PictureContext> context = current();
    out.state = find_state(context != nullptr);
    out.coordinator = m_coordinator;
    out.peer = m_link->peer();
    out.tiles = m_rendered.tiles;
    out.pixels = m_rendered.pixels;
    if (context) {
        const PictureContext::Load load = context->load();
        out.waiting = load.waiting;
        out.begun = load.begun;
        out.box_bytes = load.box_bytes;
    }
    return out;
}

}  // namespace terravox::farm
