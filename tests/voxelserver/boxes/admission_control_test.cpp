#include "voxelserver/boxes/admission_control.hpp"

#include <atomic>
#include <thread>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;
using boxes::AdmissionControl;

TEST_CASE("a gate lets its number in, its line wait, and turns others away",
          "[voxelserver][boxes]") {
    AdmissionControl gate(1, 0);
    {
        const AdmissionControl::Pass inside(gate);
        CHECK_THROWS_AS(AdmissionControl::Pass(gate), boxes::OverloadedError);
    }
    CHECK_NOTHROW(AdmissionControl::Pass(gate));

    // With room in the line, all get in, never two at once.
    AdmissionControl queue(1, 8);
    std::atomic<int> inside{0}, most{0}, entered{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i)
        threads.emplace_back([&] {
            for (int n = 0; n < 200; ++n) {
                const AdmissionControl::Pass pass(queue);
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
    AdmissionControl gate(1, 4);
    std::atomic<bool> ahead_in{false};
    std::thread ahead;
    {
        const AdmissionControl::Pass asked(gate);
        ahead = std::thread([&] {
            const AdmissionControl::PrefetchPermit pass(gate);
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
        const AdmissionControl::Pass asked(gate);
        ahead.join();
    }
    CHECK(gate.counts().ahead_running == 0);
}

TEST_CASE("closing lets those who wait to work ahead go home", "[voxelserver][boxes]") {
    AdmissionControl gate(1, 4);
    const AdmissionControl::Pass asked(gate);
    std::thread waiting(
        [&] { CHECK_FALSE(static_cast<bool>(AdmissionControl::PrefetchPermit(gate))); });
    gate.close();
    waiting.join();
    CHECK_FALSE(static_cast<bool>(AdmissionControl::PrefetchPermit(gate)));
}

TEST_CASE("a gate that refuses turns away those who wait and those who come, not those inside",
          "[voxelserver][boxes]") {
    AdmissionControl gate(1, 4);
    std::thread waiting;
    {
        const AdmissionControl::Pass inside(gate);
        waiting = std::thread(
            [&] { CHECK_THROWS_AS(AdmissionControl::Pass(gate), boxes::OverloadedError); });
        while (gate.counts().waiting == 0)
            std::this_thread::yield();
        gate.refuse();
        waiting.join();
        CHECK(gate.counts().running == 1);
    }
    CHECK_THROWS_AS(AdmissionControl::Pass(gate), boxes::OverloadedError);
    CHECK_FALSE(static_cast<bool>(AdmissionControl::PrefetchPermit(gate)));
    CHECK(gate.counts().waiting == 0);
}

TEST_CASE("places are limited and come back", "[voxelserver][boxes]") {
    boxes::Slots places(2);
    const boxes::Slots::Place first(places);
    {
        const boxes::Slots::Place second(places);
        CHECK_THROWS_AS(boxes::Slots::Place(places), boxes::OverloadedError);
        CHECK_THROWS_AS(boxes::Slots::Place(places), boxes::OverloadedError);
    }
    CHECK_NOTHROW(boxes::Slots::Place(places));
}
