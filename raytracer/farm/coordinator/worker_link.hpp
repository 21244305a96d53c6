#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "raytracer/farm/coordinator/box_supplier.hpp"
#include "raytracer/farm/coordinator/socket_processor.hpp"
#include "raytracer/farm/net/link.hpp"
#include "raytracer/farm/wire/picture_spec.hpp"

namespace terravox::farm {

/// Measures the latency of a link by its pings: a moving average of the times until their answers.
///
/// A ping has a stamp, its time, which the peer echoes. The peer could echo anything, so the stamps
/// of pings without an answer are kept, and no other stamp counts. Thread-safe; its own mutex is
/// held while nothing else is called.
class LatencyMeter {
public:
    /// Number of pings without an answer that are kept; the oldest are forgotten first.
    static constexpr std::size_t kMaxOutstanding = 64;

    /// To be called before a ping goes out: its answer may arrive before the sender continues.
    /// @param stamp of the ping: the time now, in ns of any steady clock
    void ping_sent(std::uint64_t stamp);
    /// Takes the answer to a ping. Pings that were sent before this one no longer wait for theirs,
    /// since a link keeps the order.
    /// @param stamp  that the peer has echoed
    /// @param now_ns on the clock of the stamps
    /// @return false: no ping with this stamp waits for an answer, and nothing has changed
    bool pong_received(std::uint64_t stamp, std::uint64_t now_ns);
    /// @return average in seconds; 0: no ping was answered yet
    [[nodiscard]] double average_s() const noexcept { return m_average_s; }

private:
    std::mutex m_mutex;
    std::deque<std::uint64_t> m_outstanding;  ///< stamps, oldest first
    std::atomic<double> m_average_s{0};       ///< written with the mutex held
};

/// Where a worker gets a picture's boxes from.
struct BoxSource {
    /// Address of a voxel server or box archive that workers can reach; or empty.
    std::string server;
    /// "generated:SEED"; or empty. If both are empty, boxes come from the coordinator, which is
    /// also the fallback otherwise.
    std::string generated;
};

/// What workers receive about the picture under way.
struct PictureCall {
    std::uint64_t id = 0;
    std::uint64_t world_id = 0;
    PictureSpec spec;
    BoxSource source;
    tiles::PixelContent content;
};

/// What a worker has answered to a coordinator's hello, after its own.
enum class WorkerAnswer : std::uint8_t {
    kNone,
    kAccepts,  ///< it has sent anything but a refusal or a goodbye: it works for this coordinator
    kBusy,     ///< it refuses, and may accept later
    kRefuses,  ///< for good
};

/// The coordinator's end of a link to a worker, after the hellos. Thread-safe.
class WorkerLink {
public:
    /// Notifications from a worker. Called on the thread of run().
    struct Reported {
        std::function<void()> accepts;  ///< WorkerAnswer::kAccepts; once, before the others
        /// The worker drains; the tiles that it returns must be leased to others.
        std::function<void(const std::vector<tiles::RenderTile>& given_back)> drains;
        std::function<void(bool on)> pauses;  ///< it was paused or resumed on its own side
    };
    WorkerLink(std::unique_ptr<net::Link> link, farm::Hello worker, BoxSupplier& boxes,
               Reported reported);
    ~WorkerLink();

    /// Announces a picture to the worker.
    /// @return the processor that renders its tiles there
    [[nodiscard]] std::shared_ptr<SocketProcessor> begin(const PictureCall& call);
    /// Reads until the link ends.
    /// @return the reason
    [[nodiscard]] std::string run();

    void ping();  ///< skipped when so much is queued before it that it would measure nothing
    void bye(const std::string& reason) noexcept;
    void refuse_it(const std::string& why) noexcept;
    void abort() noexcept { m_link->abort(); }
    [[nodiscard]] bool is_revoked() { return m_link->is_revoked(); }
    [[nodiscard]] std::chrono::steady_clock::duration silent_for() noexcept;

    [[nodiscard]] const farm::Hello& hello() const noexcept { return m_hello; }
    [[nodiscard]] const std::string& peer() const noexcept { return m_link->peer(); }
    /// The name in its certificate; empty with a token.
    [[nodiscard]] const std::string& certified_name() const noexcept { return m_certified_name; }
    [[nodiscard]] double latency_s() const noexcept { return m_latency.average_s(); }
    [[nodiscard]] farm::Heartbeat heartbeat() const;
    [[nodiscard]] net::Link::Traffic traffic() const noexcept { return m_link->traffic(); }
    [[nodiscard]] bool draining() const noexcept { return m_draining; }
    /// Whether run() ended because the worker sent something invalid.
    [[nodiscard]] bool misbehaved() const noexcept { return m_misbehaved; }
    [[nodiscard]] WorkerAnswer answer() const noexcept { return m_answer; }

private:
    void take_answer(const farm::Frame& first);
    /// @return what is wrong with the frame; empty: nothing
    [[nodiscard]] std::string take(const farm::Frame& frame);
    /// Measures the latency if the stamp is one of a ping that waits for its answer.
    /// @return what is wrong: the stamp is of the future, or older than an hour; any other is
    /// ignored
    [[nodiscard]] std::string take_pong(const farm::Pong& pong);
    [[nodiscard]] std::string take_box_request(const farm::BoxRequest& request);
    void take_heartbeat(const farm::Heartbeat& heartbeat);
    void take_drain(const farm::Drain& drain);
    /// @return the processor of a picture; nullptr: the picture has ended
    [[nodiscard]] std::shared_ptr<SocketProcessor> find_processor(std::uint64_t picture);
    [[nodiscard]] std::string send_state(const std::string& hash);

    const std::shared_ptr<net::Link> m_link;
    const farm::Hello m_hello;
    const std::string m_certified_name;
    BoxSupplier& m_boxes;
    const std::uint64_t m_requester;  ///< number of this link at the supplier
    const Reported m_reported;
    mutable std::mutex m_mutex;
    std::shared_ptr<SocketProcessor> m_processor;
    std::map<std::string, std::string> m_states;  ///< texts of the picture under way, by hash
    farm::Heartbeat m_heartbeat;
    std::atomic<std::int64_t> m_heard_ns;
    std::atomic<std::uint64_t> m_received_bytes{0};
    LatencyMeter m_latency;
    std::atomic<bool> m_draining{false};
    std::atomic<bool> m_misbehaved{false};
    std::atomic<WorkerAnswer> m_answer{WorkerAnswer::kNone};
    bool m_bye = false;
    bool m_over = false;
};

}  // namespace terravox::farm
