#include "voxelserver/boxes/gate.hpp"

#include <atomic>
#include <thread>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;
using boxes::Gate;

TEST_CASE("a gate lets its number in, its line wait, and turns others away",
          "[voxelserver][boxes]") {
    Gate gate(1, 0);
    {
        const Gate::Pass inside(gate);
        CHECK_THROWS_AS(Gate::Pass(gate), boxes::Busy);
    }
    CHECK_NOTHROW(Gate::Pass(gate));

    // With room in the line, all get in, never two at once.
    Gate queue(1, 8);
    std::atomic<int> inside{0}, most{0}, entered{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i)
        threads.emplace_back([&] {
            for (int n = 0; n < 200; ++n) {
                const Gate::Pass pass(queue);
                most = std::max(most.load(), ++inside);
                ++entered;
                --inside;
            }
        });
    for (auto& t : threads)
        t.join();
    CHECK(most == 1);
    CHECK(entered == 1600);
}

TEST_CASE("work ahead begins only when nothing that was asked for runs, and does not hold it up",
          "[voxelserver][boxes]") {
    Gate gate(1, 4);
    std::atomic<bool> ahead_in{false};
    std::thread ahead;
    {
        const Gate::Pass asked(gate);
        ahead = std::thread([&] {
            const Gate::AheadPass pass(gate);
            CHECK(static_cast<bool>(pass));
            ahead_in = true;
            while (gate.counts().running == 0)
                std::this_thread::yield();  // somebody asks while this runs, and gets in
        });
        for (int i = 0; i < 1000; ++i)
            std::this_thread::yield();
        CHECK_FALSE(ahead_in);
        CHECK(gate.counts().ahead_running == 0);
    }
    while (!ahead_in)
        std::this_thread::yield();
    {
        const Gate::Pass asked(gate);
        ahead.join();
    }
    CHECK(gate.counts().ahead_running == 0);
}

TEST_CASE("closing lets those who wait to work ahead go home", "[voxelserver][boxes]") {
    Gate gate(1, 4);
    const Gate::Pass asked(gate);
    std::thread waiting([&] { CHECK_FALSE(static_cast<bool>(Gate::AheadPass(gate))); });
    gate.close();
    waiting.join();
    CHECK_FALSE(static_cast<bool>(Gate::AheadPass(gate)));
}

TEST_CASE("a gate that refuses turns away those who wait and those who come, not those inside",
          "[voxelserver][boxes]") {
    Gate gate(1, 4);
    std::thread waiting;
    {
        const Gate::Pass inside(gate);
        waiting = std::thread([&] { CHECK_THROWS_AS(Gate::Pass(gate), boxes::Busy); });
        while (gate.counts().waiting == 0)
            std::this_thread::yield();
        gate.refuse();
        waiting.join();
        CHECK(gate.counts().running == 1);
    }
    CHECK_THROWS_AS(Gate::Pass(gate), boxes::Busy);
    CHECK_FALSE(static_cast<bool>(Gate::AheadPass(gate)));
    CHECK(gate.counts().waiting == 0);
}

TEST_CASE("places are limited and come back", "[voxelserver][boxes]") {
    boxes::Places places(2);
    const boxes::Places::Place first(places);
    {
        const boxes::Places::Place second(places);
        CHECK_THROWS_AS(boxes::Places::Place(places), boxes::Busy);
        CHECK_THROWS_AS(boxes::Places::Place(places), boxes::Busy);
    }
    CHECK_NOTHROW(boxes::Places::Place(places));
}
