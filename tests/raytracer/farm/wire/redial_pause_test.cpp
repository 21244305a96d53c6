#include <algorithm>
#include <chrono>
#include <vector>

#include "raytracer/farm/wire/frames.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using farm::farm_times;
using farm::RedialPause;

namespace {

std::vector<std::chrono::milliseconds> list_pauses(RedialPause& pause, int number) {
    std::vector<std::chrono::milliseconds> out;
    for (int i = 0; i < number; ++i)
        out.push_back(pause.next());
    return out;
}

}  // namespace

TEST_CASE("pauses between attempts double up to the longest, and begin anew after a success",
          "[raytracer][farm]") {
    const auto seed = GENERATE(range(std::uint64_t{1}, std::uint64_t{20}));
    INFO("seed " << seed);
    RedialPause pause(seed);
    auto whole = farm_times().redial;
    for (const auto one : list_pauses(pause, 20)) {
        CHECK(one <= whole);
        CHECK(one >= whole * 3 / 4);
        whole = std::min(whole * 2, farm_times().max_redial);
    }
    CHECK(whole == farm_times().max_redial);
    pause.reset();
    CHECK(pause.next() <= farm_times().redial);
}

TEST_CASE("pauses depend on the seed alone, and differ between seeds", "[raytracer][farm]") {
    RedialPause one(7);
    RedialPause same(7);
    RedialPause other(8);
    const auto pauses = list_pauses(one, 20);
    CHECK(pauses == list_pauses(same, 20));
    CHECK(pauses != list_pauses(other, 20));
}
