#include "common/thread/start_threads.hpp"

#include <memory>
#include <stdexcept>

#include "tests/catch.hpp"

using terravox::thread::on_new_thread;

namespace {

int refused() {
    throw std::logic_error("the system has threads");
}

}  // namespace

TEST_CASE("work on a new thread is over when it returns, and its value is moved",
          "[common][thread]") {
    const auto here = std::this_thread::get_id();
    std::thread::id there = here;
    const std::unique_ptr<int> made = on_new_thread(
        [&] {
            there = std::this_thread::get_id();
            return std::make_unique<int>(7);
        },
        [] { return std::unique_ptr<int>(); });
    REQUIRE(made);
    CHECK(*made == 7);
    CHECK(there != here);
}

TEST_CASE("what work on a new thread throws reaches the caller", "[common][thread]") {
    const auto fails = []() -> int { throw std::out_of_range("too far"); };
    CHECK_THROWS_AS(on_new_thread(fails, refused), std::out_of_range);
}
