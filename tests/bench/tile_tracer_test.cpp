#include "tests/bench/entries/tile_tracer.hpp"

#include <algorithm>
#include <atomic>

#include "tests/catch.hpp"

using namespace terravox;
using namespace terravox::bench;

namespace {

constexpr int kAcross = NeutralScene::kWidthPx / kTracedTilePx;
constexpr int kDown = NeutralScene::kHeightPx / kTracedTilePx;

/// Counts how often each tile was traced.
class CountingTracer final : public TileTracer {
public:
    explicit CountingTracer(int threads) : m_busy(static_cast<std::size_t>(threads)) {}
    void begin(const NeutralView&) override {
        for (auto* counts : {&m_primary, &m_shadow})
            for (auto& count : *counts)
                count = 0;
    }
    void trace_primary(int x0, int y0, int thread) override { count(m_primary, x0, y0, thread); }
    void trace_shadow(int x0, int y0, int thread) override {
        if (m_primary[tile(x0, y0)] != 1)
            ++m_faults;
        count(m_shadow, x0, y0, thread);
    }
    [[nodiscard]] std::size_t hits() const override { return once(m_primary); }
    [[nodiscard]] std::size_t shadowed() const override { return once(m_shadow); }
    [[nodiscard]] int faults() const { return m_faults; }

private:
    using Counts = std::vector<std::atomic<int>>;
    static std::size_t tile(int x0, int y0) {
        return static_cast<std::size_t>(y0 / kTracedTilePx * kAcross + x0 / kTracedTilePx);
    }
    static std::size_t once(const Counts& counts) {
        return static_cast<std::size_t>(std::count(counts.begin(), counts.end(), 1));
    }
    void count(Counts& counts, int x0, int y0, int thread) {
        if (thread < 0 || static_cast<std::size_t>(thread) >= m_busy.size() ||
            x0 % kTracedTilePx != 0 || y0 % kTracedTilePx != 0) {
            ++m_faults;
            return;
        }
        auto& busy = m_busy[static_cast<std::size_t>(thread)];
        if (busy.exchange(true))
            ++m_faults;
        ++counts.at(tile(x0, y0));
        busy = false;
    }
    Counts m_primary = Counts(std::size_t{kAcross} * kDown);
    Counts m_shadow = Counts(std::size_t{kAcross} * kDown);
    std::vector<std::atomic<bool>> m_busy;
    std::atomic<int> m_faults{0};
};

}  // namespace

TEST_CASE(
    "each tile is traced once, by threads that have a number of their own, shadows after the "
    "primary rays",
    "[bench][tiles]") {
    const int threads = GENERATE(1, 2, 5);
    CAPTURE(threads);
    CountingTracer tracer(threads);
    const NeutralView view{"any", {0, 0, 0}, {1, 0, 0}, 40};
    for (int again = 0; again < 2; ++again) {
        const ViewTimes times = time_view(tracer, view, threads);
        CHECK(times.hits == std::size_t{kAcross} * kDown);
        CHECK(times.shadowed == std::size_t{kAcross} * kDown);
    }
    CHECK(tracer.faults() == 0);
}

TEST_CASE("the best of two views has the least of each time", "[bench][tiles]") {
    ViewTimes best;
    best.primary = {2, 1};
    best.shadow = {3, 4};
    ViewTimes other;
    other.primary = {1, 2};
    other.shadow = {4, 3};
    best.keep_best(other);
    CHECK(best.wall_s() == 1 + 3);
    CHECK(best.cpu_s() == 1 + 3);
}
