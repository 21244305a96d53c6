#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "raytracer/farm/coordinator/known_workers.hpp"
#include "raytracer/farm/coordinator/worker_link.hpp"
#include "raytracer/farm/net/endpoint.hpp"
#include "raytracer/farm/processors/processor_pool.hpp"

namespace terravox::farm {

struct FarmOptions {
    std::vector<sockets::Address> dial;      ///< workers that listen
    std::optional<sockets::Address> listen;  ///< for workers that dial in
    net::Credentials credentials;
    [[nodiscard]] bool any() const noexcept { return !dial.empty() || listen; }
};

/// What came of a link to a worker.
struct LinkOutcome {
    enum class Kind : std::uint8_t {
        kWorked,  ///< the worker has finished tiles
        kNotNow,  ///< it has not, and may do so later
        kNever,   ///< dialling it again is pointless
    } kind = Kind::kNever;
    std::string why;  ///< reason of kNotNow and kNever; empty: it has been logged
};

/// The workers of a coordinator, dialled or dialling in: it performs the handshake, monitors them,
/// and assigns them to the pool that renders. Outlives many pictures.
///
/// A worker counts only once it has accepted the coordinator (WorkerAnswer): one that is busy
/// exchanges hellos before it refuses.
///
/// One mutex guards the workers and the picture under way. Each link has a thread that reads it;
/// one thread pings and gives up silent workers; one for each address dials again and again. The
/// mutex may be held while the pool's is taken and while a picture is announced to a worker, never
/// the other way round: gone() is called without the pool's.
class Farm {
public:
    /// @param source where workers may get boxes from
    /// @throws Error when it cannot listen
    Farm(FarmOptions options, blocks::BlockManager& blocks, BoxSource source);
    ~Farm() { finish(); }  ///< says goodbye to the workers

    /// Assigns every worker, connected now or later, to this pool until end().
    /// @param scene, view of the picture
    /// @throws Error
    void begin(processors::ProcessorPool& pool, const scene::Scene& scene, const shade::View& view);
    void end();
    /// To be called by PoolSettings::gone.
    void gone(processors::ProcessorPool::MemberId member, const std::string& why, bool expelled);

    /// Dials a worker that listens at this address, from now on.
    /// @throws Error when no thread can be started for it
    void dial(const sockets::Address& worker);
    /// Disconnects a worker and stops dialling it.
    /// @param worker as Address::text
    void hang_up(const std::string& worker);
    [[nodiscard]] std::vector<std::string> dialled() const;

    /// Port that it listens on; 0: none.
    [[nodiscard]] std::uint16_t port() const noexcept {
        return m_listener ? m_listener->port() : 0;
    }
    /// Number of connected workers that have accepted this coordinator.
    [[nodiscard]] std::size_t workers() const;

    /// A connected worker that has accepted this coordinator.
    struct Worker {
        processors::ProcessorPool::MemberId member = 0;  ///< 0: in no pool now
        std::string name;
        std::string peer;
        int threads = 0;
        double latency_s = 0;
        std::uint64_t memory_bytes = 0;
        std::uint64_t received_bytes = 0;
        bool draining = false;
    };
    [[nodiscard]] std::vector<Worker> status() const;
    /// Sets the source of the status for observers that query it through the listener. Called on
    /// any thread.
    void set_status_source(std::function<farm::Status()> source);

    /// Serves a worker, or an observer, at the other end of a link until the link ends.
    /// @param dialled address that was dialled; empty: the peer dialled in
    LinkOutcome serve(std::unique_ptr<net::Link> link, const std::string& dialled);

private:
    /// A worker after the hellos, until its link ends.
    struct ConnectedWorker {
        std::shared_ptr<WorkerLink> link;
        std::string dialled;  ///< address; empty: it dialled in
        bool accepted = false;
        processors::ProcessorPool::MemberId member = 0;
        /// Paused by an observer of this coordinator; the worker may also be paused on its own
        /// side.
        bool paused = false;
        [[nodiscard]] bool takes_nothing() const { return paused || link->heartbeat().paused(); }
    };
    /// The workers that are connected now, each with a number that is never used again.
    struct Connected {
        std::map<std::uint64_t, ConnectedWorker> workers;  ///< by id
        std::uint64_t next_id = 1;
    };
    /// Between begin() and end(); outside them there is neither pool nor call.
    struct PictureUnderWay {
        processors::ProcessorPool* pool = nullptr;
        std::optional<PictureCall> call;
        std::uint64_t next_id = 1;  ///< of the next picture
    };

    void finish() noexcept;
    [[nodiscard]] LinkOutcome serve_worker(std::unique_ptr<net::Link> link,
                                           const std::string& dialled);
    /// Lets a worker that has accepted take part.
    void welcome(std::uint64_t id);
    /// Exchanges the hellos, and serves an observer until its link ends.
    /// @return the hello of a worker; nullopt: an observer, or a worker that is banned
    /// @throws HelloError, Error
    [[nodiscard]] std::optional<farm::Hello> greet(net::Link& link, const std::string& dialled);
    [[nodiscard]] WorkerLink::Reported make_notifications(std::uint64_t id);
    /// Removes a worker whose link has ended, and logs the reason if it had a part in the picture.
    void remove(std::uint64_t id, const WorkerLink& worker, const std::string& dialled,
                const std::string& why);
    void observe(net::Link& link);
    /// @return whether there is such a worker
    bool pause(const std::string& worker, bool on);
    void dial_again_and_again(const sockets::Address& address, std::uint64_t turn);
    void watch();
    void attach(ConnectedWorker& entry);
    [[nodiscard]] bool is_banned(const BanList::Worker& worker) const;

    const FarmOptions m_options;
    blocks::BlockManager& m_blocks;
    const BoxSource m_source;
    BoxSupplier m_supplier;
    mutable std::mutex m_mutex;
    std::condition_variable m_wake;
    Connected m_connected;
    PictureUnderWay m_picture;
    BanList m_bans;
    net::RefusalLog m_refusals;  ///< of workers that dialled in
    std::function<farm::Status()> m_status_source;
    bool m_stop = false;
    std::unique_ptr<net::Listener> m_listener;
    DialledAddresses m_dialled;  ///< each has a thread
    std::vector<std::thread> m_threads;
};

}  // namespace terravox::farm
