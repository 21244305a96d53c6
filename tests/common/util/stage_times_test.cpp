#include "common/util/stage_times.hpp"

#include <thread>

#include "tests/catch.hpp"

using terravox::util::StageTimes;
using terravox::util::Stopwatch;

TEST_CASE("stages add up and keep the order in which they were first seen",
          "[common][util][stage_times]") {
    StageTimes times;
    CHECK(times.stages().empty());
    times.add("load", 0.5);
    times.add("filter", 0.25);
    times.add("load", 1.0);
    const auto stages = times.stages();
    REQUIRE(stages.size() == 2);
    CHECK(stages[0].name == "load");
    CHECK(stages[0].seconds == 1.5);
    CHECK(stages[0].count == 2);
    CHECK(stages[1].name == "filter");
    CHECK(stages[1].seconds == 0.25);
    CHECK(stages[1].count == 1);
}

TEST_CASE("a scope adds itself once, when it ends, also by an exception",
          "[common][util][stage_times]") {
    StageTimes times;
    {
        const StageTimes::Scope scope(times, "work");
        CHECK(times.stages().empty());
    }
    try {
        const StageTimes::Scope scope(times, "work");
        throw 1;
    } catch (int) {
    }
    REQUIRE(times.stages().size() == 1);
    CHECK(times.stages()[0].count == 2);
    CHECK(times.stages()[0].seconds >= 0);
}

TEST_CASE("a scope's time does not hold that of scopes inside it; a clock's does",
          "[common][util][stage_times]") {
    constexpr double kLong_s = 0.01;
    constexpr double kShort_s = 0.005;
    const auto pass = [](double seconds) {
        const Stopwatch watch;
        while (watch.seconds() < seconds) {
        }
    };
    StageTimes times;
    const Stopwatch all;
    {
        const StageTimes::Clock clock(times, "clock");
        StageTimes::Scope outer(times, "outer");
        pass(kShort_s);
        {
            const StageTimes::Scope inner(times, "inner");
            pass(kLong_s);
        }
        std::thread([&] { const StageTimes::Scope elsewhere(times, "elsewhere"); }).join();
        outer.hand_over("part", kShort_s / 2);
    }
    const double all_s = all.seconds();
    const auto seconds = [&](const std::string& name) {
        for (const auto& stage : times.stages())
            if (stage.name == name)
                return stage.seconds;
        return -1.0;
    };
    CHECK(seconds("inner") >= kLong_s);
    CHECK(seconds("outer") >= kShort_s / 2);
    CHECK(seconds("part") == kShort_s / 2);
    CHECK(seconds("elsewhere") >= 0);
    CHECK(seconds("outer") + seconds("inner") + seconds("part") <= all_s);
    CHECK(seconds("clock") >= kShort_s + kLong_s);
}

TEST_CASE("many threads may add at once", "[common][util][stage_times]") {
    StageTimes times;
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&times, t] {
            for (int i = 0; i < 1000; ++i)
                times.add(t % 2 == 0 ? "even" : "odd", 1);
        });
    for (auto& thread : threads)
        thread.join();
    const auto stages = times.stages();
    REQUIRE(stages.size() == 2);
    for (const auto& stage : stages) {
        CHECK(stage.seconds == 2000);
        CHECK(stage.count == 2000);
    }
}
