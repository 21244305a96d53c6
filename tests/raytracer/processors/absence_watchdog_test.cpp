#include "raytracer/processors/absence_watchdog.hpp"

#include "tests/catch.hpp"
#include "tests/raytracer/processors/pool_parts.hpp"

using namespace terravox;
using namespace terravox::test;
using processors::AbsenceWatchdog;
using Alarm = AbsenceWatchdog::Alarm;

TEST_CASE("a pool without members warns every ten seconds", "[raytracer][sched]") {
    AbsenceWatchdog watchdog(std::nullopt, at_s(100));
    CHECK(watchdog.poll(at_s(102)) == Alarm::kNone);
    CHECK(watchdog.poll(at_s(110)) == Alarm::kNone);
    CHECK(watchdog.poll(at_s(111)) == Alarm::kWarn);
    CHECK(watchdog.poll(at_s(112)) == Alarm::kNone);
    CHECK(watchdog.poll(at_s(122)) == Alarm::kWarn);
    CHECK(watchdog.poll(at_s(100'000)) == Alarm::kWarn);
}

TEST_CASE("after the last member has left, the first warning comes after a second",
          "[raytracer][sched]") {
    AbsenceWatchdog watchdog(std::nullopt, at_s(0));
    watchdog.set_present();
    CHECK(watchdog.poll(at_s(1000)) == Alarm::kNone);
    watchdog.set_absent(at_s(1000));
    CHECK(watchdog.poll(at_s(1001)) == Alarm::kNone);
    CHECK(watchdog.poll(at_s(1001.5)) == Alarm::kWarn);
    CHECK(watchdog.poll(at_s(1002)) == Alarm::kNone);
    watchdog.set_present();
    CHECK(watchdog.poll(at_s(2000)) == Alarm::kNone);
}

TEST_CASE("a wait with a timeout ends, and begins anew when a member leaves",
          "[raytracer][sched]") {
    AbsenceWatchdog watchdog(std::chrono::seconds(5), at_s(0));
    CHECK(watchdog.poll(at_s(5)) == Alarm::kNone);
    CHECK(watchdog.poll(at_s(5.5)) == Alarm::kTimeout);
    CHECK(watchdog.absent_for(at_s(5.5)) == at_s(5.5) - at_s(0));
    watchdog.set_absent(at_s(6));
    CHECK(watchdog.poll(at_s(8)) == Alarm::kWarn);
    CHECK(watchdog.poll(at_s(11.5)) == Alarm::kTimeout);
    CHECK(watchdog.poll(at_s(12)) == Alarm::kTimeout);
}
