#pragma once

#include <chrono>
#include <cstdint>
#include <random>
#include <string>
#include <utility>

#include "common/util/error.hpp"
#include "common/voxel/box.hpp"
#include "raytracer/core/tiles/tile.hpp"
#include "raytracer/farm/net/farm.pb.h"
#include "raytracer/farm/net/link.hpp"

namespace terravox::farm {

[[nodiscard]] inline farm::Tile to_frame(const tiles::RenderTile& t, std::uint64_t id) {
    farm::Tile out;
    out.set_id(id);
    out.set_index(t.index);
    out.set_pass(t.pass);
    out.set_x0(t.x0);
    out.set_y0(t.y0);
    out.set_x1(t.x1);
    out.set_y1(t.y1);
    out.set_step(t.step);
    out.set_refines(t.refines);
    out.set_first_sample(t.first_sample);
    out.set_samples(t.samples);
    return out;
}
[[nodiscard]] inline tiles::RenderTile from_frame(const farm::Tile& t) {
    return {t.index(), t.pass(), t.x0(),      t.y0(),           t.x1(),
            t.y1(),    t.step(), t.refines(), t.first_sample(), t.samples()};
}

inline void to_frame(const voxel::BoxKey& key, farm::BoxKey& out) {
    out.set_level(key.level);
    out.set_bx(key.bx);
    out.set_by(key.by);
    out.set_bz(key.bz);
}
[[nodiscard]] inline voxel::BoxKey from_frame(const farm::BoxKey& k) {
    voxel::BoxKey out;
    out.level = k.level();
    out.bx = k.bx();
    out.by = k.by();
    out.bz = k.bz();
    return out;
}

/// Intervals and limits. They are shorter in tests (TERRAVOX_FARM_TEST=1), which would otherwise
/// wait for deliberately long times.
struct FarmTimes {
    /// Interval of the coordinator's pings, whose answers measure the latency.
    std::chrono::milliseconds ping{1000};
    /// Time without data after which a peer is given up.
    std::chrono::milliseconds silence{12'000};
    std::chrono::milliseconds heartbeat{2000};  ///< interval of the worker's heartbeats
    std::chrono::milliseconds min_deadline{10'000};
    std::chrono::milliseconds redial{1000};
    std::chrono::milliseconds max_redial{30'000};
};
[[nodiscard]] const FarmTimes& farm_times();

/// The pauses between attempts to connect to a peer: each twice as long as the one before, from
/// FarmTimes::redial to max_redial, less up to a quarter by chance, so that programs that were
/// started together do not dial together. Not thread-safe.
class RedialPause {
public:
    /// @param seed of the chance
    explicit RedialPause(std::uint64_t seed) : m_random(static_cast<std::uint32_t>(seed)) {}

    [[nodiscard]] std::chrono::milliseconds next();
    /// After a success: the next pause is the shortest again.
    void reset() noexcept { m_next = farm_times().redial; }

private:
    std::minstd_rand m_random;
    std::chrono::milliseconds m_next = farm_times().redial;
};

/// The peer cannot or will not work with this program. Final, unless it is busy.
class HelloError : public util::Error {
public:
    HelloError(const std::string& peer, std::string why, bool is_busy)
        : util::Error("meet " + peer + ": " + why), reason(std::move(why)), busy(is_busy) {}
    std::string reason;  ///< without the peer
    bool busy;           ///< it may accept later
};

struct OwnHello {
    farm::Role role = farm::COORDINATOR;
    int threads = 0;
    std::uint64_t memory_bytes = 0;
    int capacity = 0;  ///< of a worker: tiles
    std::string name;  ///< empty: host and process
};
/// The first frame of a link: protocol, software and build of this program, and this machine.
[[nodiscard]] farm::Hello make_hello(const OwnHello& own);

/// Sends this side's hello, waits for the peer's, and compares: protocol, software, build,
/// architecture, role. A mismatch is reported to the peer.
/// @param wanted the role that the peer must have
/// @param timeout after which the link is aborted
/// @throws HelloError that names the mismatch with the values of both sides, or the peer's reason
/// for refusing; Error when no thread can be started for the timeout
[[nodiscard]] farm::Hello meet(net::Link& link, const farm::Hello& own,
                               std::initializer_list<farm::Role> wanted,
                               std::chrono::milliseconds timeout = std::chrono::seconds(5));

/// Sends the peer the reason of a refusal, and ends the link.
void refuse(net::Link& link, const std::string& reason, bool busy = false) noexcept;

}  // namespace terravox::farm
