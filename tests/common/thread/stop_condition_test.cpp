#include "common/thread/stop.hpp"

#include "tests/catch.hpp"

using terravox::thread::StopCondition;
using namespace std::chrono_literals;

TEST_CASE("work stops by either token or at its deadline", "[common][thread]") {
    std::stop_source first;
    std::stop_source second;
    const auto now = StopCondition::Clock::now();
    CHECK_FALSE(StopCondition({}).is_met());
    CHECK_FALSE(StopCondition(first.get_token(), second.get_token()).is_met());
    CHECK_FALSE(StopCondition(first.get_token(), {}, now + 1h).is_met());
    CHECK(StopCondition(first.get_token(), {}, now).is_met());

    const StopCondition either(first.get_token(), second.get_token());
    second.request_stop();
    CHECK(either.is_met());
    first.request_stop();
    CHECK(StopCondition(first.get_token()).is_met());
}
