#include <terravox/world.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "raytracer/apps/library/guarded.hpp"
#include "raytracer/apps/library/ray_order.hpp"
#include "raytracer/apps/library/state.hpp"
#include "raytracer/core/walk/lane_walk.hpp"
#include "raytracer/core/walk/walk.hpp"

namespace terravox {
namespace {

/// Rays as callers give them: three numbers for each.
class Rays {
public:
    Rays(std::span<const double> origins, std::span<const double> directions,
         const WorldState& state, const CastOptions& options)
        : m_origins(origins),
          m_directions(directions),
          m_state(state),
          m_cut(state.world->info().bounds, options.level),
          m_bounds(state.frame.measure_bounds(state.world->info().bounds)),
          m_range(options.range_m / state.info.voxel_m) {
        if (origins.size() != directions.size() || origins.size() % 3 != 0)
            throw util::UsageError("cast rays: " + std::to_string(origins.size()) +
                                   " numbers of origins and " + std::to_string(directions.size()) +
                                   " of directions; allowed: three for each ray");
        if (!(options.range_m > 0))
            throw util::UsageError("cast rays: range_m = " + std::to_string(options.range_m) +
                                   "; allowed: above 0");
    }

    [[nodiscard]] std::size_t count() const noexcept { return m_origins.size() / 3; }
    [[nodiscard]] const walk::LevelCut& cut() const noexcept { return m_cut; }
    [[nodiscard]] double range_voxels() const noexcept { return m_range; }
    /// @throws util::UsageError for a direction without a length, and for numbers that are none
    [[nodiscard]] core::Ray at(std::size_t i) const {
        const double* origin = &m_origins[3 * i];
        const double* towards = &m_directions[3 * i];
        core::Ray out{m_state.frame.to_voxels({origin[0], origin[1], origin[2]}),
                      m_state.frame.to_voxels({towards[0], towards[1], towards[2]})};
        // Squares of very small and of very large numbers are lost.
        const double most = std::max(
            {std::abs(out.direction.x), std::abs(out.direction.y), std::abs(out.direction.z)});
        if (most > 0 && std::isfinite(most))
            out.direction = {out.direction.x / most, out.direction.y / most,
                             out.direction.z / most};
        const double length = core::length(out.direction);
        const bool is_ray = std::isfinite(out.origin.x) && std::isfinite(out.origin.y) &&
                            std::isfinite(out.origin.z) && std::isfinite(length) && length > 0;
        if (!is_ray)
            throw util::UsageError("cast rays: ray " + std::to_string(i) +
                                   " has an endless number or no direction; allowed: finite "
                                   "numbers, and a direction with a length");
        out.direction = out.direction * (1 / length);
        return out;
    }

    /// Has the processor fetch a ray that will be read soon: RayOrder jumps in memory, and waiting
    /// for each ray took a fifth of the time.
    void prefetch(std::size_t i) const noexcept {
        for (const double* ray : {&m_origins[3 * i], &m_directions[3 * i]}) {
            __builtin_prefetch(ray);
            __builtin_prefetch(ray + 2);
        }
    }
    /// What RayOrder needs to know of a ray, in units of the map.
    /// @throws util::UsageError as at()
    [[nodiscard]] RayStart start(std::size_t i) const {
        const double* origin = &m_origins[3 * i];
        const double* towards = &m_directions[3 * i];
        const double low[3] = {m_bounds.west, m_bounds.south, m_bounds.bottom};
        const double high[3] = {m_bounds.east, m_bounds.north, m_bounds.top};
        double sum = 0;
        double entry = 0;
        std::uint8_t octant = 0;
        for (int a = 0; a < 3; ++a) {
            sum += std::abs(origin[a]) + std::abs(towards[a]);
            const bool forward = towards[a] > 0;
            octant = static_cast<std::uint8_t>(octant << 1 | (forward ? 1 : 0));
            if (towards[a] == 0)
                continue;
            const double crossing = ((forward ? low[a] : high[a]) - origin[a]) / towards[a];
            entry = std::max(entry, crossing);
        }
        if (!std::isfinite(sum))
            (void)at(i);
        const auto where = [&](int a) {
            const double v = origin[a] + entry * towards[a];
            // In this order, so that what is no number becomes the lower bound.
            return static_cast<float>(std::max(low[a], std::min(v, high[a])));
        };
        return {where(0), where(1), octant};
    }

private:
    const std::span<const double> m_origins;
    const std::span<const double> m_directions;
    const WorldState& m_state;
    const walk::LevelCut m_cut;
    const MapBounds m_bounds;  ///< of the world
    const double m_range;      ///< level-0 voxels
};

/// Walks rays of one thread, sixteen at a time where the machine has the instructions, to the same
/// bits as one by one.
class RayBatch {
public:
    RayBatch(const Rays& rays, blocks::BlockManager& blocks)
        : m_rays(rays),
          m_reader(blocks),
          m_walk(m_reader, rays.cut()),
          m_lanes(walk::lane_walk(m_reader, rays.cut())) {}

    /// Calls take(i, hit) for each of some rays: of a hit within range, or nullptr.
    /// @param order the rays first + order[0], first + order[1], ...
    template <class Take>
    void cast(std::size_t first, std::span<const std::uint32_t> order, bool with_hits,
              const Take& take) {
        begin(first, order, with_hits);
        if (m_lanes)
            m_lanes->trace(m_waiting);
        for (std::size_t i = 0; i < order.size(); ++i) {
            while (m_ends[i] == walk::WalkEnd::kWaits)
                walk_alone(i);
            take(first + order[i], m_ends[i] == walk::WalkEnd::kHit ? &m_hits[i] : nullptr);
        }
    }

private:
    void begin(std::size_t first, std::span<const std::uint32_t> order, bool with_hits) {
        const std::size_t count = order.size();
        m_states.resize(count);
        m_ends.assign(count, walk::WalkEnd::kMiss);
        m_hits.assign(count, walk::Hit{});
        m_waiting.clear();
        for (std::size_t i = 0; i < count; ++i) {
            m_rays.prefetch(first + order[std::min(i + kAhead, count - 1)]);
            m_states[i] = core::RayState(m_rays.at(first + order[i]));
            if (!m_states[i].enter(m_rays.cut().entry_bounds()))
                continue;
            m_ends[i] = walk::WalkEnd::kWaits;
            m_waiting.push_back({&m_states[i], &m_ends[i], m_rays.range_voxels(),
                                 with_hits ? &m_hits[i] : nullptr});
        }
    }

    void walk_alone(std::size_t i) {
        m_ends[i] =
            m_walk.first_hit(m_states[i], walk::StopAt::kSolid, m_rays.range_voxels(), m_hits[i]);
        if (m_ends[i] == walk::WalkEnd::kWaits)
            (void)m_reader.blocks().get(m_walk.missing());
    }

    /// Rays between one that is read and the one whose numbers are fetched meanwhile.
    static constexpr std::size_t kAhead = 24;

    const Rays& m_rays;
    walk::BlockReader m_reader;
    walk::RayWalk m_walk;
    std::optional<walk::LaneWalk> m_lanes;
    std::vector<core::RayState> m_states;
    std::vector<walk::WalkEnd> m_ends;
    std::vector<walk::Hit> m_hits;
    std::vector<walk::LaneRay> m_waiting;
};

/// Rays that are put into an order together. A multiple of kChunk.
constexpr std::size_t kWindow = 131072;
/// Rays of one task: so few that threads end at about the same time.
constexpr std::size_t kChunk = 8192;
/// Rays that are walked together.
constexpr std::size_t kTogether = 1024;

std::size_t count_parts(std::size_t count, std::size_t size) noexcept {
    return (count + size - 1) / size;
}

/// The order in which rays are walked: of each window a permutation of [0, its rays).
/// @throws util::UsageError as Rays::at
std::vector<std::uint32_t> walk_order(const Rays& rays, int threads, const Control& control) {
    std::vector<std::uint32_t> out(rays.count());
    if (rays.count() <= kTogether) {
        std::iota(out.begin(), out.end(), 0);
        return out;
    }
    thread::parallel_for(count_parts(rays.count(), kWindow), threads, [&](std::size_t window) {
        check_stop(control);
        const std::size_t first = window * kWindow;
        std::vector<RayStart> starts(std::min(kWindow, rays.count() - first));
        for (std::size_t i = 0; i < starts.size(); ++i)
            starts[i] = rays.start(first + i);
        RayOrder().sort(starts, std::span(out).subspan(first, starts.size()));
    });
    return out;
}

/// Calls take(i, hit) for each ray, on several threads.
template <class Take>
void cast_each(const Rays& rays, const WorldState& state, const CastOptions& options,
               const Control& control, bool with_hits, const Take& take) {
    const std::vector<std::uint32_t> order = walk_order(rays, options.threads, control);
    const std::size_t chunks = count_parts(rays.count(), kChunk);
    Steps steps(control, chunks);
    thread::parallel_for(chunks, options.threads, [&](std::size_t chunk) {
        check_stop(control);
        RayBatch batch(rays, state.blocks);
        const std::size_t window = chunk * kChunk / kWindow * kWindow;
        const std::size_t end = std::min((chunk + 1) * kChunk, rays.count());
        for (std::size_t first = chunk * kChunk; first < end; first += kTogether) {
            const std::size_t count = std::min(kTogether, end - first);
            batch.cast(window, std::span(order).subspan(first, count), with_hits, take);
        }
        steps.add_one();
    });
}

}  // namespace

RayHits World::cast(std::span<const double> origins, std::span<const double> directions,
                    const CastOptions& options, const Control& control) const {
    return guarded(control, [&] {
        const WorldCall call(*m_state, options.threads);
        m_state->check_level(options.level);
        const Rays rays(origins, directions, *m_state, options);
        RayHits out;
        out.distance_m.assign(rays.count(), std::numeric_limits<double>::infinity());
        out.voxel.resize(rays.count());
        out.face.assign(rays.count(), Face::kNone);
        out.material.resize(rays.count());
        std::atomic<std::size_t> holes{0};
        cast_each(rays, *m_state, options, control, true, [&](std::size_t i, const walk::Hit* hit) {
            if (hit == nullptr)
                return;
            if (hit->hole) {
                out.distance_m[i] = std::numeric_limits<double>::quiet_NaN();
                ++holes;
                return;
            }
            out.distance_m[i] = hit->t * m_state->info.voxel_m;
            out.voxel[i] = {hit->voxel.x, hit->voxel.y, hit->voxel.z};
            out.face[i] = static_cast<Face>(hit->face);
            out.material[i] = static_cast<std::uint8_t>(hit->attr.material);
        });
        out.holes = call.checked(holes);
        return out;
    });
}

Occlusion World::occluded(std::span<const double> origins, std::span<const double> directions,
                          const CastOptions& options, const Control& control) const {
    return guarded(control, [&] {
        const WorldCall call(*m_state, options.threads);
        m_state->check_level(options.level);
        const Rays rays(origins, directions, *m_state, options);
        Occlusion out;
        out.occluded.resize(rays.count());
        std::atomic<std::size_t> holes{0};
        cast_each(rays, *m_state, options, control, false,
                  [&](std::size_t i, const walk::Hit* hit) {
                      out.occluded[i] = hit != nullptr ? 1 : 0;
                      holes += hit != nullptr && hit->hole ? 1 : 0;
                  });
        out.holes = call.checked(holes);
        return out;
    });
}

}  // namespace terravox
