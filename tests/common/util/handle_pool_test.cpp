#include "common/util/handle_pool.hpp"

#include <memory>
#include <optional>
#include <stdexcept>

#include "tests/catch.hpp"

using terravox::util::HandlePool;

TEST_CASE("a handle is lent to one caller at a time, and stays open for the next",
          "[common][util][handle_pool]") {
    int opened = 0;
    const auto open = [&] { return std::make_unique<int>(++opened); };
    HandlePool<std::unique_ptr<int>> pool(2);
    {
        const auto first = pool.borrow(open);
        const auto second = pool.borrow(open);
        const auto third = pool.borrow(open);
        CHECK(*first == 1);
        CHECK(*second == 2);
        CHECK(*third.get() == 3);
    }
    // Given back in reverse order: 3, 2; there is no room for 1.
    int sum = 0;
    pool.for_each([&](int number) { sum += number; });
    CHECK(sum == 5);
    CHECK(*pool.borrow(open) == 2);
    {
        auto broken = pool.borrow(open);
        CHECK(*broken == 2);
        broken.drop();
    }
    CHECK(*pool.borrow(open) == 3);
    CHECK(opened == 3);
}

TEST_CASE("a handle that cannot be opened is not kept", "[common][util][handle_pool]") {
    HandlePool<std::unique_ptr<int>> pool;
    const auto fail = []() -> std::unique_ptr<int> { throw std::runtime_error("no more"); };
    CHECK_THROWS_WITH(pool.borrow(fail), "no more");
    CHECK(*pool.borrow([] { return std::make_unique<int>(7); }) == 7);
    CHECK(*pool.borrow(fail) == 7);
}
