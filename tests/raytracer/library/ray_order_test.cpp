#include "raytracer/library/ray_order.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;

namespace {

std::vector<std::uint32_t> order_of(const std::vector<RayStart>& starts) {
    std::vector<std::uint32_t> out(starts.size());
    RayOrder().sort(starts, out);
    return out;
}

std::vector<std::uint32_t> as_they_come(std::size_t count) {
    std::vector<std::uint32_t> out(count);
    std::iota(out.begin(), out.end(), 0);
    return out;
}

/// How far one has to go from start to start.
double way_through(const std::vector<RayStart>& starts, const std::vector<std::uint32_t>& order) {
    double out = 0;
    for (std::size_t i = 1; i < order.size(); ++i)
        out += std::hypot(starts[order[i]].x - starts[order[i - 1]].x,
                          starts[order[i]].z - starts[order[i - 1]].z);
    return out;
}

}  // namespace

TEST_CASE("ray order: each ray once, octants together, neighbours next to each other",
          "[library][order]") {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> coordinate(-3000, 9000);
    std::vector<RayStart> starts(20000);
    for (RayStart& start : starts)
        start = {coordinate(random), coordinate(random), static_cast<std::uint8_t>(random() % 8)};
    const std::vector<std::uint32_t> order = order_of(starts);
    std::vector<std::uint32_t> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    CHECK(sorted == as_they_come(starts.size()));
    CHECK(std::is_sorted(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return starts[a].octant < starts[b].octant;
    }));
    CHECK(way_through(starts, order) < way_through(starts, as_they_come(starts.size())) / 15);
}

TEST_CASE("ray order: rays of one cell keep their order", "[library][order]") {
    CHECK(order_of({}).empty());
    CHECK(order_of({{5, 5, 3}}) == as_they_come(1));
    const std::vector<RayStart> here(500, RayStart{2e9F, -2e9F, 7});
    CHECK(order_of(here) == as_they_come(500));
    CHECK(order_of({{0, 0, 1}, {100, 100, 0}, {0.5F, 0, 1}, {100, 99.5F, 0}}) ==
          std::vector<std::uint32_t>{1, 3, 0, 2});
}
