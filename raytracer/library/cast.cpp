#include <terravox/world.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "raytracer/library/guarded.hpp"
#include "raytracer/library/state.hpp"
#include "raytracer/library/steps.hpp"
#include "raytracer/walk/walker.hpp"

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

private:
    const std::span<const double> m_origins;
    const std::span<const double> m_directions;
    const WorldState& m_state;
    const walk::LevelCut m_cut;
    const double m_range;  ///< level-0 voxels
};

/// Calls take(i, hit) for each ray, on several threads: of a hit within range, or nullopt.
template <class Take>
void cast_each(const Rays& rays, const WorldState& state, int threads, const Control& control,
               const Take& take) {
    constexpr std::size_t kTogether = 8192;
    const std::size_t chunks = (rays.count() + kTogether - 1) / kTogether;
    Steps steps(control, chunks);
    thread::parallel_for(chunks, threads, [&](std::size_t chunk) {
        check_stop(control);
        walk::BlockReader reader(state.blocks);
        walk::Walker walker(reader, rays.cut());
        const std::size_t end = std::min((chunk + 1) * kTogether, rays.count());
        for (std::size_t i = chunk * kTogether; i < end; ++i)
            take(i, walker.first_hit(rays.at(i), walk::StopAt::kSolid, rays.range_voxels()));
        steps.add_one();
    });
}

}  // namespace

RayHits World::cast(std::span<const double> origins, std::span<const double> directions,
                    const CastOptions& options, const Control& control) const {
    return guarded([&] {
        m_state->check_level(options.level);
        const Rays rays(origins, directions, *m_state, options);
        RayHits out;
        out.distance_m.assign(rays.count(), std::numeric_limits<double>::infinity());
        out.voxel.resize(rays.count());
        out.face.assign(rays.count(), Face::kNone);
        out.material.resize(rays.count());
        std::atomic<std::size_t> holes{0};
        cast_each(rays, *m_state, options.threads, control,
                  [&](std::size_t i, const std::optional<walk::Hit>& hit) {
                      if (!hit)
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
        out.holes = holes;
        return out;
    });
}

Occlusion World::occluded(std::span<const double> origins, std::span<const double> directions,
                          const CastOptions& options, const Control& control) const {
    return guarded([&] {
        m_state->check_level(options.level);
        const Rays rays(origins, directions, *m_state, options);
        Occlusion out;
        out.occluded.resize(rays.count());
        std::atomic<std::size_t> holes{0};
        cast_each(rays, *m_state, options.threads, control,
                  [&](std::size_t i, const std::optional<walk::Hit>& hit) {
                      out.occluded[i] = hit ? 1 : 0;
                      holes += hit && hit->hole ? 1 : 0;
                  });
        out.holes = holes;
        return out;
    });
}

}  // namespace terravox
