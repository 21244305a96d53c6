#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace terravox {

/// What tracing took. Sums over tiles. Rays, and those that met holes, do not depend on who traced; steps, slabs, spared and waits do.
struct TraceCounts {
    static constexpr std::size_t kKinds = 7;  ///< RayKind
    std::array<std::uint64_t, kKinds> rays{};
    std::uint64_t steps = 0;        ///< cells and voxels visited by rays
    std::uint64_t slabs = 0;        ///< visited by beams and shafts
    std::uint64_t spared = 0;       ///< rays that a beam or shaft answered: no step of their own
    std::uint64_t parked = 0;       ///< times that a ray was laid aside
    std::uint64_t hole_rays = 0;    ///< that ended at a box that could not be had, shadow rays too

    [[nodiscard]] std::uint64_t all_rays() const noexcept {
        std::uint64_t sum = 0;
        for (const std::uint64_t n : rays) sum += n;
        return sum;
    }
    void add(const TraceCounts& o) noexcept {
        for (std::size_t i = 0; i < kKinds; ++i) rays[i] += o.rays[i];
        steps += o.steps, slabs += o.slabs, spared += o.spared, parked += o.parked, hole_rays += o.hole_rays;
    }
};

}  // namespace terravox
