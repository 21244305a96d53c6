#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

#include "common/voxel/box.hpp"
#include "common/voxel/colour.hpp"
#include "common/voxel/material.hpp"

namespace terravox::tiles {

/// Which things cover a pixel, and how much of it; by descending share once sorted.
struct Matte {
    static constexpr std::size_t kMax = 6;
    std::array<std::uint32_t, kMax> object{};
    std::array<float, kMax> share{};  ///< of the pixel, [0, 1]; 0: no more entries

    /// Adds to the share of a thing. When there is no room for another thing, it is left out.
    void add(std::uint32_t what, float more) noexcept {
        for (std::size_t i = 0; i < kMax; ++i) {
            if (share[i] > 0 && object[i] != what)
                continue;
            object[i] = what;
            share[i] += more;
            return;
        }
    }
    void scale(float by) noexcept {
        for (float& s : share)
            s *= by;
    }
};

/// What a pixel's rays hit first. Means over the samples that hit anything, except for the light,
/// which is averaged over all samples.
struct LayerSample {
    /// Light that reached the first hit directly from sun and sky; `direct` + `indirect` is the
    /// pixel's colour.
    voxel::Colour direct;
    voxel::Colour indirect;  ///< by way of other surfaces
    voxel::Colour albedo;    ///< share of light that the surface reflects; 0 where nothing is hit
    std::array<float, 3> normal{};    ///< x east, y up, z south
    std::array<float, 3> position{};  ///< metres from Camera::picture_origin(), the same axes
    float sun = 0;                    ///< share of the first hits' sunlight that is not in shadow
    float water = 0;  ///< share of the samples with a hit that meet water or glass first
    voxel::Material material = voxel::Material::kAir;  ///< of the first sample
    Matte materials;                                   ///< voxel::Material
    Matte squares;                                     ///< index in the SquareGrid

    /// Combines the means with those of more samples.
    /// @param own, others number of samples that each stands for
    /// @param own_hits, other_hits number of those that hit anything
    void merge(const LayerSample& more, float own, float others, float own_hits,
               float other_hits) noexcept;
};

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
[[nodiscard]] constexpr const char* to_name(TraceStage stage) noexcept {
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

/// A rectangle of the picture in one pass, [x0, x1) x [y0, y1) in pixels. Only pixels whose
/// coordinates are multiples of `step` are traced, except those that an earlier pass has traced
/// (multiples of 2 * step, when `refines`).
struct RenderTile {
    std::uint32_t index = 0;  ///< within the pass, in the order of the plan
    std::uint32_t pass = 0;
    int x0 = 0;
    int y0 = 0;
    int x1 = 0;
    int y1 = 0;
    int step = 1;
    bool refines = false;
    /// Of each pixel; 0: as many as the scene specifies.
    std::uint32_t first_sample = 0;
    std::uint32_t samples = 0;
    friend bool operator==(const RenderTile&, const RenderTile&) = default;

    /// Calls visit(x, y) for each pixel to trace, row by row.
    template <class Visit>
    void each_pixel(const Visit& visit) const {
        const auto first = [this](int v) { return (v + step - 1) / step * step; };
        for (int y = first(y0); y < y1; y += step)
            for (int x = first(x0); x < x1; x += step)
                if (!refines || x % (2 * step) != 0 || y % (2 * step) != 0)
                    visit(x, y);
    }
};

struct PixelSample {
    voxel::Colour colour;       ///< linear
    float alpha = 0;            ///< share of samples that hit the world
    float depth_m = 0;          ///< mean distance of those samples; infinity where none hit
    std::uint32_t samples = 1;  ///< number of samples in the mean
    float error = 0;            ///< standard error of its brightness; 0 with a single sample

    /// Whether the error is at most this share of the brightness.
    [[nodiscard]] bool is_known(double share) const noexcept;
    /// Combines the mean with that of more samples of the same pixel.
    void merge(const PixelSample& more) noexcept;
};

/// What a picture's pixels hold in addition to their samples; the same for all of its tiles.
struct PixelContent {
    bool layers = false;
    std::uint8_t bands = 0;  ///< measured values; 0: a picture
    friend bool operator==(const PixelContent&, const PixelContent&) = default;
};

/// A finished tile: one sample for each pixel that each_pixel visits, in its order.
struct TileResult {
    RenderTile tile;
    std::vector<PixelSample> samples;
    /// Parallel to `samples`; empty where layers were not requested.
    std::vector<LayerSample> layers;
    /// Of an analysis: PixelContent::bands values for each sample, pixel by pixel; else empty.
    std::vector<float> bands;
    TraceCounts counts;
    std::set<voxel::BoxKey> holes;  ///< boxes that its rays needed and that were not available
    /// Replaces a result that was delivered before, whose maker turned out not to be trustworthy.
    bool again = false;
};

}  // namespace terravox::tiles
