#include "raytracer/farm/coordinator/worker_link.hpp"

#include <algorithm>
#include <utility>

#include "raytracer/farm/wire/frames.hpp"

namespace terravox::farm {

void LatencyMeter::ping_sent(std::uint64_t stamp) {
    const std::lock_guard lock(m_mutex);
    if (m_outstanding.size() == kMaxOutstanding)
        m_outstanding.pop_front();
    m_outstanding.push_back(stamp);
}

bool LatencyMeter::pong_received(std::uint64_t stamp, std::uint64_t now_ns) {
    const std::lock_guard lock(m_mutex);
    const auto found = std::find(m_outstanding.begin(), m_outstanding.end(), stamp);
    if (found == m_outstanding.end())
        return false;
    m_outstanding.erase(m_outstanding.begin(), found + 1);
    const double passed_s = static_cast<double>(now_ns - stamp) / 1e9;
    const double before_s = m_average_s;
    m_average_s = before_s == 0 ? passed_s : 0.8 * before_s + 0.2 * passed_s;
    return true;
}

namespace {

// No answer takes as long: an hour.
constexpr std::uint64_t kMaxPong_ns = 3'600'000'000'000;

std::int64_t now_ns() noexcept {
    return std::chrono::steady_clock::now().time_since_epoch().count();
}

std::uint64_t next_requester() {
    static std::atomic<std::uint64_t> next{1};
    return next++;
}

}  // namespace

WorkerLink::WorkerLink(std::unique_ptr<net::Link> link, farm::Hello worker, BoxSupplier& boxes,
                       Reported reported)
    : m_link(std::move(link)),
      m_hello(std::move(worker)),
      m_certified_name(m_link->certified_name()),
      m_boxes(boxes),
      m_requester(next_requester()),
      m_reported(std::move(reported)),
      m_heard_ns(now_ns()) {}

WorkerLink::~WorkerLink() {
    m_link->abort();
    m_boxes.forget(m_requester);
}

std::shared_ptr<SocketProcessor> WorkerLink::begin(const PictureCall& call) {
    auto processor =
        std::make_shared<SocketProcessor>(m_link, m_hello.name(), call.id, call.content,
                                          static_cast<int>(m_hello.capacity()), m_boxes.blocks());
    farm::Frame frame;
    farm::Picture& picture = *frame.mutable_picture();
    bool over = false;
    picture.set_id(call.id);
    picture.set_world_id(call.world_id);
    {
        const std::lock_guard lock(m_mutex);
        m_states.clear();
        const auto name = [&](const std::string& text) {
            std::string hash = state_hash(text);
            m_states[hash] = text;
            return hash;
        };
        picture.set_scene(name(call.spec.scene));
        picture.set_materials(name(call.spec.materials));
        picture.set_world(name(call.spec.world));
        m_processor = processor;
        over = m_over;
    }
    if (over) {
        processor->lost("the link has ended");
        return processor;
    }
    if (!call.source.server.empty())
        picture.set_server(call.source.server);
    else if (!call.source.generated.empty())
        picture.set_generated(call.source.generated);
    else
        picture.set_asked(true);
    (void)m_link->send(std::move(frame));
    return processor;
}

std::string WorkerLink::send_state(const std::string& hash) {
    farm::Frame frame;
    {
        const std::lock_guard lock(m_mutex);
        const auto found = m_states.find(hash);
        if (found == m_states.end())
            return {};  // of a picture that has ended meanwhile
        frame.mutable_state()->set_hash(hash);
        frame.mutable_state()->set_content(found->second);
    }
    (void)m_link->send(std::move(frame));
    return {};
}

std::shared_ptr<SocketProcessor> WorkerLink::find_processor(std::uint64_t picture) {
    const std::lock_guard lock(m_mutex);
    if (m_processor && m_processor->picture() == picture)
        return m_processor;
    return nullptr;
}

std::string WorkerLink::take_pong(const farm::Pong& pong) {
    const auto now = static_cast<std::uint64_t>(now_ns());
    const std::uint64_t passed_ns = now - pong.stamp();  // huge if the stamp is of the future
    if (passed_ns >= kMaxPong_ns)
        return "its answer to a ping is invalid";
    (void)m_latency.pong_received(pong.stamp(), now);
    return {};
}

std::string WorkerLink::take_box_request(const farm::BoxRequest& request) {
    BoxSupplier::ReplyChannel channel;
    channel.send = [link = std::weak_ptr(m_link)](farm::Frame reply) {
        const auto to = link.lock();
        return to && to->send(std::move(reply));
    };
    channel.queued_bytes = [link = std::weak_ptr(m_link)] {
        const auto to = link.lock();
        return to ? to->traffic().queued_bytes : 0;
    };
    if (m_boxes.request(m_requester, request, channel))
        return {};
    return "it requests more boxes than it may, or of another world";
}

void WorkerLink::take_heartbeat(const farm::Heartbeat& heartbeat) {
    bool changed = false;
    {
        const std::lock_guard lock(m_mutex);
        changed = m_heartbeat.paused() != heartbeat.paused();
        m_heartbeat = heartbeat;
    }
    if (changed)
        m_reported.pauses(heartbeat.paused());
}

void WorkerLink::take_drain(const farm::Drain& drain) {
    m_draining = true;
    std::shared_ptr<SocketProcessor> processor;
    {
        const std::lock_guard lock(m_mutex);
        processor = m_processor;
    }
    m_reported.drains(
        processor ? processor->list_tiles({drain.given_back().begin(), drain.given_back().end()})
                  : std::vector<tiles::RenderTile>{});
}

void WorkerLink::take_answer(const farm::Frame& first) {
    if (first.has_refusal()) {
        m_answer = first.refusal().busy() ? WorkerAnswer::kBusy : WorkerAnswer::kRefuses;
    } else if (!first.has_bye()) {
        m_answer = WorkerAnswer::kAccepts;
        m_reported.accepts();
    }
}

std::string WorkerLink::take(const farm::Frame& frame) {
    switch (frame.what_case()) {
        case farm::Frame::kPong: return take_pong(frame.pong());
        case farm::Frame::kPing: {
            farm::Frame pong;
            pong.mutable_pong()->set_stamp(frame.ping().stamp());
            (void)m_link->send(std::move(pong));
            return {};
        }
        case farm::Frame::kNeedState: return send_state(frame.need_state().hash());
        case farm::Frame::kDone:
            if (const auto processor = find_processor(frame.done().picture()))
                processor->done(frame.done());
            return {};
        case farm::Frame::kFailed:
            if (const auto processor = find_processor(frame.failed().picture()))
                processor->failed(frame.failed());
            return {};
        case farm::Frame::kNeedBox: return take_box_request(frame.need_box());
        case farm::Frame::kHeartbeat: take_heartbeat(frame.heartbeat()); return {};
        case farm::Frame::kDrain: take_drain(frame.drain()); return {};
        case farm::Frame::kBye: m_bye = true; return {};
        case farm::Frame::kRefusal:
            m_bye = true;
            return "it refuses: " + frame.refusal().reason().substr(0, 400);
        default:
            return "it sends a frame that no worker sends (" +
                   std::to_string(static_cast<int>(frame.what_case())) + ")";
    }
}

std::string WorkerLink::run() {
    std::string wrong;
    while (auto frame = m_link->receive()) {
        m_heard_ns = now_ns();
        if (m_answer == WorkerAnswer::kNone)
            take_answer(*frame);
        wrong = take(*frame);
        if (!wrong.empty() || m_bye)
            break;
    }
    m_misbehaved = !wrong.empty() && !m_bye;
    if (m_misbehaved)
        refuse_it(wrong);
    std::string why = wrong;
    if (why.empty())
        why = m_bye ? "it left" : m_link->why_ended();
    if (why.empty())
        why = "the link ended";
    m_link->abort();
    std::shared_ptr<SocketProcessor> processor;
    {
        const std::lock_guard lock(m_mutex);
        processor = m_processor;
        m_over = true;
    }
    if (processor && m_misbehaved)
        processor->misbehaved(why);
    else if (processor)
        processor->lost(why);
    return why;
}

void WorkerLink::ping() {
    if (m_link->traffic().queued_bytes > net::kMaxBeforePing_bytes)
        return;
    farm::Frame frame;
    const auto stamp = static_cast<std::uint64_t>(now_ns());
    frame.mutable_ping()->set_stamp(stamp);
    m_latency.ping_sent(stamp);
    (void)m_link->send(std::move(frame));
}

void WorkerLink::bye(const std::string& reason) noexcept {
    try {
        farm::Frame frame;
        frame.mutable_bye()->set_reason(reason);
        (void)m_link->send(std::move(frame));
        m_link->close();
    } catch (...) {
        m_link->abort();
    }
}

void WorkerLink::refuse_it(const std::string& why) noexcept {
    refuse(*m_link, why);
}

std::chrono::steady_clock::duration WorkerLink::silent_for() noexcept {
    // A large frame arrives piece by piece.
    if (const auto received = m_link->traffic().received_bytes;
        m_received_bytes.exchange(received) != received)
        m_heard_ns = now_ns();
    return std::chrono::steady_clock::duration(now_ns() - m_heard_ns.load());
}

farm::Heartbeat WorkerLink::heartbeat() const {
    const std::lock_guard lock(m_mutex);
    return m_heartbeat;
}

}  // namespace terravox::farm
