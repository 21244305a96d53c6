#include "raytracer/farm/processors/pool_members.hpp"

#include <vector>

#include "tests/catch.hpp"
#include "tests/raytracer/farm/processors/pool_parts.hpp"

using namespace terravox;
using namespace terravox::test;
using processors::AbsenceWatchdog;
using Alarm = AbsenceWatchdog::Alarm;

TEST_CASE("a wait with a timeout ends, and begins anew when a member that answered leaves",
          "[raytracer][sched]") {
    AbsenceWatchdog watchdog(std::chrono::seconds(5), at_s(0));
    CHECK(watchdog.poll(at_s(5)) == Alarm::kNone);
    CHECK(watchdog.poll(at_s(5.5)) == Alarm::kTimeout);
    CHECK(watchdog.absent_for(at_s(5.5)) == at_s(5.5) - at_s(0));
    watchdog.set_present(at_s(5.5));
    CHECK(watchdog.poll(at_s(5.6)) == Alarm::kNone);
    watchdog.set_answered();
    watchdog.set_absent(at_s(6));
    CHECK(watchdog.poll(at_s(8)) == Alarm::kWarn);
    watchdog.set_absent(at_s(8));  // nobody has come meanwhile
    CHECK(watchdog.poll(at_s(11.5)) == Alarm::kTimeout);
    CHECK(watchdog.poll(at_s(12)) == Alarm::kTimeout);
}

TEST_CASE("members that come and go without a result do not prolong the wait",
          "[raytracer][sched]") {
    AbsenceWatchdog watchdog(std::chrono::seconds(30), at_s(0));
    std::vector<int> warnings_s;
    int second = 0;
    for (Alarm alarm = Alarm::kNone; alarm != Alarm::kTimeout; ++second) {
        REQUIRE(second < 100);
        // Another member every second, for half of it.
        watchdog.set_present(at_s(second));
        watchdog.set_absent(at_s(second + 0.5));
        alarm = watchdog.poll(at_s(second + 1));
        if (alarm == Alarm::kWarn)
            warnings_s.push_back(second);
    }
    CHECK(second == 61);
    CHECK(warnings_s == std::vector<int>{10, 21, 32, 43, 54});
}
