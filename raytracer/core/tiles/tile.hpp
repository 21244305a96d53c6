#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "common/voxel/box.hpp"
#include "common/voxel/colour.hpp"
#include "raytracer/core/tiles/layers.hpp"
#include "raytracer/core/tiles/trace_counts.hpp"

namespace terravox::tiles {

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
    /// Of an analysis: core::band_count values for each sample, pixel by pixel; empty for pictures.
    std::vector<float> bands;
    TraceCounts counts;
    std::set<voxel::BoxKey> holes;  ///< boxes that its rays needed and that were not available
    /// Replaces a result that was delivered before, whose maker turned out not to be trustworthy.
    bool again = false;
};

}  // namespace terravox::tiles
