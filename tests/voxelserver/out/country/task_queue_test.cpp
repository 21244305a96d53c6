#include "voxelserver/out/country/task.hpp"

#include <numeric>
#include <set>

#include "tests/catch.hpp"

namespace terravox::country {
namespace {

std::vector<int> up_to(int last) {
    std::vector<int> out(static_cast<std::size_t>(last));
    std::iota(out.begin(), out.end(), 1);
    return out;
}

}  // namespace

TEST_CASE("places begin far from each other and go on with neighbours", "[country][queue]") {
    TaskQueue queue(up_to(9));
    CHECK(queue.take(0) == 1);
    CHECK(queue.take(0) == 6);
    queue.ended(1);
    CHECK(queue.take(1) == 2);
    queue.ended(6);
    CHECK(queue.take(6) == 7);
}

TEST_CASE("a place whose neighbour is taken goes where most is left", "[country][queue]") {
    TaskQueue queue({1, 2, 5, 6, 7, 8});
    CHECK(queue.take(0) == 5);
    CHECK(queue.take(0) == 7);  // 6 to 8, of which 5 is at work next to 6
    queue.ended(5);
    CHECK(queue.take(5) == 6);
    queue.ended(6);
    CHECK(queue.take(6) == 1);
}

TEST_CASE("each task is taken once, however many places there are", "[country][queue]") {
    const int places = GENERATE(1, 2, 3, 7, 40);
    const int tasks = GENERATE(0, 1, 2, 9, 33);
    CAPTURE(places, tasks);
    TaskQueue queue(up_to(tasks));
    std::vector<int> last(static_cast<std::size_t>(places), 0);
    std::set<int> seen;
    while (!queue.empty()) {
        for (int& at : last) {
            const auto number = queue.take(at);
            if (!number)
                continue;
            CHECK(seen.insert(*number).second);
            queue.ended(at);
            at = *number;
        }
    }
    CHECK(seen.size() == static_cast<std::size_t>(tasks));
    CHECK_FALSE(queue.take(0).has_value());
}

TEST_CASE("a task that is put back is taken again", "[country][queue]") {
    TaskQueue queue({3});
    CHECK(queue.take(0) == 3);
    CHECK(queue.empty());
    queue.put_back(3);
    CHECK(queue.take(3) == 3);
}

}  // namespace terravox::country
