#include "voxelserver/serve/boxes/admission_control.hpp"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;
using boxes::AdmissionControl;

TEST_CASE("admission control runs and queues a limited number, and rejects the others",
          "[voxelserver][boxes]") {
    AdmissionControl control(1, 0);
    std::atomic<bool> rejected{false};
    std::thread second;
    {
        const AdmissionControl::Permit inside(control);
        second = std::thread([&] {
            try {
                const AdmissionControl::Permit pass(control);
            } catch (const boxes::OverloadedError&) {
                rejected = true;
            }
        });
        while (!rejected && control.counts().waiting == 0)
            std::this_thread::yield();
        CHECK(rejected);
    }
    second.join();
    CHECK_NOTHROW(AdmissionControl::Permit(control));

    // With room in the line, all get in, never two at once.
    AdmissionControl queue(1, 8);
    std::atomic<int> inside{0}, most{0}, entered{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i)
        threads.emplace_back([&] {
            for (int n = 0; n < 200; ++n) {
                const AdmissionControl::Permit pass(queue);
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

TEST_CASE("prefetching begins only while no requested work runs, and does not delay it",
          "[voxelserver][boxes]") {
    AdmissionControl control(1, 4);
    std::atomic<bool> ahead_in{false};
    std::thread ahead;
    {
        const AdmissionControl::Permit requests(control);
        ahead = std::thread([&] {
            const AdmissionControl::PrefetchPermit pass(control);
            CHECK(static_cast<bool>(pass));
            ahead_in = true;
            while (control.counts().running == 0)
                std::this_thread::yield();  // a request while this runs is admitted
        });
        for (int i = 0; i < 1000; ++i)
            std::this_thread::yield();
        CHECK_FALSE(ahead_in);
        CHECK(control.counts().ahead_running == 0);
    }
    while (!ahead_in)
        std::this_thread::yield();
    {
        const AdmissionControl::Permit requests(control);
        ahead.join();
    }
    CHECK(control.counts().ahead_running == 0);
}

TEST_CASE("closing ends the wait for prefetching", "[voxelserver][boxes]") {
    AdmissionControl control(1, 4);
    const AdmissionControl::Permit requests(control);
    std::thread waiting(
        [&] { CHECK_FALSE(static_cast<bool>(AdmissionControl::PrefetchPermit(control))); });
    control.close();
    waiting.join();
    CHECK_FALSE(static_cast<bool>(AdmissionControl::PrefetchPermit(control)));
}

TEST_CASE("refusing rejects waiting and new requests, not running ones", "[voxelserver][boxes]") {
    AdmissionControl control(1, 4);
    std::thread waiting;
    {
        const AdmissionControl::Permit inside(control);
        waiting = std::thread(
            [&] { CHECK_THROWS_AS(AdmissionControl::Permit(control), boxes::OverloadedError); });
        while (control.counts().waiting == 0)
            std::this_thread::yield();
        control.refuse();
        waiting.join();
        CHECK(control.counts().running == 1);
    }
    CHECK_THROWS_AS(AdmissionControl::Permit(control), boxes::OverloadedError);
    CHECK_FALSE(static_cast<bool>(AdmissionControl::PrefetchPermit(control)));
    CHECK(control.counts().waiting == 0);
}

TEST_CASE("places are limited and come back", "[voxelserver][boxes]") {
    boxes::Slots places(2, "wait for a box", "requests wait already");
    const boxes::Slots::Permit first(places);
    {
        const boxes::Slots::Permit second(places);
        CHECK_THROWS_AS(boxes::Slots::Permit(places), boxes::OverloadedError);
        CHECK_THROWS_AS(boxes::Slots::Permit(places), boxes::OverloadedError);
    }
    CHECK_NOTHROW(boxes::Slots::Permit(places));
}
