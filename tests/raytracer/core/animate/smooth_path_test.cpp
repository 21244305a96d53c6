#include "raytracer/core/animate/animation.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/catch.hpp"

using namespace terravox;

namespace {

struct Keys {
    std::vector<double> times;
    std::vector<double> values;
};

Keys random_keys(std::mt19937_64& random) {
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    Keys out;
    double time = unit() * 3;
    for (std::size_t n = 1 + random() % 9; n > 0; --n) {
        out.times.push_back(time);
        out.values.push_back(unit() * 200 - 100);
        time += 0.05 + unit() * 4;
    }
    return out;
}

}  // namespace

TEST_CASE("a smooth path goes through its keys exactly, and stands still outside them",
          "[raytracer][animate]") {
    std::mt19937_64 random(1);
    for (int run = 0; run < 500; ++run) {
        const Keys keys = random_keys(random);
        for (const auto kind :
             {animate::SmoothPath::Kind::kRound, animate::SmoothPath::Kind::kMonotone})
            for (const bool at_rest : {false, true}) {
                const animate::SmoothPath path(keys.times, keys.values, kind, at_rest);
                INFO("run " << run);
                for (std::size_t i = 0; i < keys.times.size(); ++i)
                    REQUIRE(path.at(keys.times[i]) == keys.values[i]);
                REQUIRE(path.at(keys.times.front() - 5) == keys.values.front());
                REQUIRE(path.at(keys.times.back() + 5) == keys.values.back());
            }
    }
}

TEST_CASE("a smooth path has neither jumps nor bends; a monotone one never swings beyond its keys",
          "[raytracer][animate]") {
    std::mt19937_64 random(2);
    for (int run = 0; run < 300; ++run) {
        const Keys keys = random_keys(random);
        for (const auto kind :
             {animate::SmoothPath::Kind::kRound, animate::SmoothPath::Kind::kMonotone}) {
            const animate::SmoothPath path(keys.times, keys.values, kind, false);
            for (std::size_t i = 1; i + 1 < keys.times.size(); ++i) {
                const double h = 1e-6;
                const double before = (path.at(keys.times[i]) - path.at(keys.times[i] - h)) / h;
                const double after = (path.at(keys.times[i] + h) - path.at(keys.times[i])) / h;
                INFO("run " << run << ", key " << i << ": " << before << " and " << after);
                REQUIRE(std::abs(before - after) < 0.2);  // second derivatives are below 1e5
            }
            for (std::size_t i = 0;
                 i + 1 < keys.times.size() && kind == animate::SmoothPath::Kind::kMonotone; ++i)
                for (double s = 0; s <= 1; s += 0.01) {
                    const double v =
                        path.at(keys.times[i] + s * (keys.times[i + 1] - keys.times[i]));
                    const double a = keys.values[i];
                    const double b = keys.values[i + 1];
                    INFO("run " << run << " after key " << i << ": " << v << " between " << a
                                << " and " << b);
                    REQUIRE((v >= std::min(a, b) - 1e-12 && v <= std::max(a, b) + 1e-12));
                }
        }
    }
}

TEST_CASE("between two keys a path is straight, or begins and ends at rest",
          "[raytracer][animate]") {
    const animate::SmoothPath straight({1, 3}, {10, 20}, animate::SmoothPath::Kind::kRound, false);
    const animate::SmoothPath gentle({1, 3}, {10, 20}, animate::SmoothPath::Kind::kRound, true);
    CHECK(straight.at(1.5) == Approx(12.5));
    CHECK(gentle.at(2) == Approx(15));
    CHECK(gentle.at(1.01) - 10 < 0.01);
    CHECK(20 - gentle.at(2.99) < 0.01);
    const animate::SmoothPath even({0, 1, 2, 3, 4}, {0, 2, 4, 6, 8},
                                   animate::SmoothPath::Kind::kRound, false);
    for (double t = 0; t <= 4; t += 0.1)
        CHECK(even.at(t) == Approx(2 * t).margin(1e-12));
    CHECK(animate::SmoothPath({0, 1, 2}, {5, 5, 5}, animate::SmoothPath::Kind::kMonotone, false)
              .at(0.7) == 5);
}
