#include "tests/bench/entries/tile_tracer.hpp"

#include <algorithm>
#include <atomic>
#include <thread>

namespace terravox::bench {
namespace {

/// What it costs to call work(x0, y0, thread) for all tiles; a thread that is done with one takes
/// the next.
template <class Work>
Cost cost_of_tiles(int threads, const Work& work) {
    constexpr int kAcross = NeutralScene::kWidthPx / kTracedTilePx;
    constexpr int kDown = NeutralScene::kHeightPx / kTracedTilePx;
    static_assert(kAcross * kTracedTilePx == NeutralScene::kWidthPx &&
                  kDown * kTracedTilePx == NeutralScene::kHeightPx);
    std::atomic<int> next{0};
    const auto run = [&](int thread) {
        for (int i = next++; i < kAcross * kDown; i = next++)
            work(i % kAcross * kTracedTilePx, i / kAcross * kTracedTilePx, thread);
    };
    return measure_cost([&] {
        std::vector<std::jthread> others;
        for (int thread = 1; thread < threads; ++thread)
            others.emplace_back(run, thread);
        run(0);
    });
}

}  // namespace

void ViewTimes::keep_best(const ViewTimes& other) noexcept {
    for (const auto part : {&ViewTimes::primary, &ViewTimes::shadow}) {
        (this->*part).wall_s = std::min((this->*part).wall_s, (other.*part).wall_s);
        (this->*part).cpu_s = std::min((this->*part).cpu_s, (other.*part).cpu_s);
    }
}

ViewTimes time_view(TileTracer& tracer, const NeutralView& view, int threads) {
    tracer.begin(view);
    ViewTimes out;
    out.primary = cost_of_tiles(
        threads, [&](int x0, int y0, int thread) { tracer.trace_primary(x0, y0, thread); });
    out.shadow = cost_of_tiles(
        threads, [&](int x0, int y0, int thread) { tracer.trace_shadow(x0, y0, thread); });
    out.hits = tracer.hits();
    out.shadowed = tracer.shadowed();
    return out;
}

}  // namespace terravox::bench
