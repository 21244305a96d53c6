#pragma once

#include <cstddef>

#include "tests/bench/clocks.hpp"
#include "tests/bench/entries/neutral_scene.hpp"

namespace terravox::bench {

inline constexpr int kTracedTilePx =
    16;  ///< edge of the tiles that tracers get; divides both edges of the picture

/// A tracer that has the neutral scene, called view by view and tile by tile, so that all are timed
/// by one loop.
///
/// Tiles are given by their first pixel. Calls for different tiles of one view may run at the same
/// time, those of one `thread` one after the other. A tile's primary rays come before its shadow
/// rays.
class TileTracer {
public:
    TileTracer() = default;
    TileTracer(const TileTracer&) = delete;
    TileTracer& operator=(const TileTracer&) = delete;
    virtual ~TileTracer() = default;

    /// What follows is of this view; forgets the one before. Not timed.
    virtual void begin(const NeutralView& view) = 0;
    /// One ray through the centre of each pixel of a tile.
    virtual void trace_primary(int x0, int y0, int thread) = 0;
    /// One ray towards the sun from each hit of a tile.
    virtual void trace_shadow(int x0, int y0, int thread) = 0;
    [[nodiscard]] virtual std::size_t hits()
        const = 0;  ///< of the primary rays traced since begin()
    [[nodiscard]] virtual std::size_t shadowed() const = 0;  ///< shadow rays that hit anything
};

/// What one view took.
struct ViewTimes {
    Cost primary;
    Cost shadow;
    std::size_t hits = 0;
    std::size_t shadowed = 0;
    /// Mray/s of processor time: what others do on the machine takes little from it.
    [[nodiscard]] double primary_rate() const noexcept {
        return NeutralScene::kWidthPx * NeutralScene::kHeightPx / primary.cpu_s / 1e6;
    }
    [[nodiscard]] double shadow_rate() const noexcept {
        return static_cast<double>(hits) / shadow.cpu_s / 1e6;
    }
    [[nodiscard]] double wall_s() const noexcept { return primary.wall_s + shadow.wall_s; }
    [[nodiscard]] double cpu_s() const noexcept { return primary.cpu_s + shadow.cpu_s; }
    /// Keeps the shorter of two times, each for itself.
    void keep_best(const ViewTimes& other) noexcept;
};

/// All primary rays of a view, then all its shadow rays. @param threads that share the tiles out,
/// at least 1
[[nodiscard]] ViewTimes time_view(TileTracer& tracer, const NeutralView& view, int threads);

}  // namespace terravox::bench
