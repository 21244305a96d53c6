#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace terravox::tiles {

/// Stages of a thread's work on a tile.
enum class TraceStage : std::uint8_t {
    kBeams,      ///< blocks of pixels, and where their rays may start
    kPrimary,    ///< rays through pixels, in packets
    kSun,        ///< shadow rays: shafts and packets
    kScattered,  ///< rays in all directions, in lanes
    kSingle,     ///< rays that walk alone; the voxels around hits
    kShading,
    kPixels,  ///< from samples to pixels
};
inline constexpr std::size_t kTraceStages = 7;
[[nodiscard]] constexpr const char* name_of(TraceStage stage) noexcept {
    constexpr const char* names[kTraceStages] = {
        "beams", "primary rays", "sun", "scattered rays", "single rays", "shading", "pixels"};
    return names[static_cast<std::size_t>(stage)];
}

/// Cost of tracing, summed over tiles. Rays, and those that met holes, do not depend on which
/// processor traced; steps, slabs, spared, waits and seconds do.
struct TraceCounts {
    static constexpr std::size_t kKinds = 8;  ///< walk::RayKind
    std::array<std::uint64_t, kKinds> rays{};
    std::uint64_t steps = 0;  ///< cells and voxels visited by rays
    std::uint64_t slabs = 0;  ///< visited by beams and shafts
    /// Rays that a beam or shaft answered: they took no steps of their own.
    std::uint64_t spared = 0;
    std::uint64_t parked = 0;  ///< times that a ray was deferred
    /// Rays that ended at a box that was not available, including shadow rays.
    std::uint64_t hole_rays = 0;
    std::array<double, kTraceStages> seconds{};  ///< by TraceStage, summed over threads

    [[nodiscard]] std::uint64_t all_rays() const noexcept {
        std::uint64_t sum = 0;
        for (const std::uint64_t n : rays)
            sum += n;
        return sum;
    }
    void add(const TraceCounts& o) noexcept {
        for (std::size_t i = 0; i < kKinds; ++i)
            rays[i] += o.rays[i];
        for (std::size_t i = 0; i < kTraceStages; ++i)
            seconds[i] += o.seconds[i];
        steps += o.steps;
        slabs += o.slabs;
        spared += o.spared;
        parked += o.parked;
        hole_rays += o.hole_rays;
    }
};

}  // namespace terravox::tiles
