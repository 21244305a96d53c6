#pragma once

#include <chrono>
#include <cstdint>
#include <random>

#include "common/voxel/box.hpp"
#include "raytracer/core/tiles/tile.hpp"
#include "raytracer/farm/net/farm.pb.h"

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

}  // namespace terravox::farm
