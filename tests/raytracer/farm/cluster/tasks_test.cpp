#include "raytracer/farm/cluster/tasks.hpp"

#include <algorithm>
#include <random>
#include <sstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using namespace terravox::cluster;

namespace {

std::vector<int> list_numbers(const std::string& array) {
    std::vector<int> out;
    std::istringstream in(array);
    for (std::string piece; std::getline(in, piece, ',');) {
        const auto dash = piece.find('-');
        const int first = std::stoi(piece);
        const int last = dash == std::string::npos ? first : std::stoi(piece.substr(dash + 1));
        for (int i = first; i <= last; ++i)
            out.push_back(i);
    }
    return out;
}

}  // namespace

TEST_CASE("each frame belongs to one task", "[cluster][tasks]") {
    const auto per_task = GENERATE(1, 2, 3, 7, 10, 11, 1000);
    const TaskPlan plan{{5, 14}, per_task};
    CHECK(plan.tasks() == (10 + per_task - 1) / per_task);
    for (int frame = 5; frame <= 14; ++frame)
        CHECK(plan.find_task(frame) == (frame - 5) / per_task);
    CHECK(plan.find_task(14) == plan.tasks() - 1);
}

TEST_CASE("numbers of an array are written shortly and mean the same", "[cluster][tasks]") {
    CHECK(array_text({0}) == "0");
    CHECK(array_text({0, 1, 2, 7, 9, 10}) == "0-2,7,9-10");
    const auto seed = GENERATE(1U, 2U, 3U, 4U, 5U);
    INFO("seed " << seed);
    std::mt19937 random(seed);
    std::vector<int> numbers;
    for (int i = 0; i < 3000; ++i)
        if (random() % 3 != 0)
            numbers.push_back(i);
    CHECK(list_numbers(array_text(numbers)) == numbers);
}

TEST_CASE("arrays stay below the limit, and every task is in one of them", "[cluster][tasks]") {
    const auto most = GENERATE(1, 2, 10, 1001);
    INFO("most " << most);
    std::mt19937 random(static_cast<unsigned>(most));
    std::vector<int> tasks;
    std::vector<int> found;
    for (int i = 0; i < 3000; ++i)
        if (random() % 5 != 0)
            tasks.push_back(i);
    for (const ArrayPiece& piece : array_pieces(tasks, most)) {
        REQUIRE_FALSE(piece.indices.empty());
        CHECK(piece.indices.front() >= 0);
        CHECK(piece.indices.back() < most);
        CHECK(piece.offset % most == 0);  // the same task has the same number in a later call
        for (const int index : piece.indices)
            found.push_back(piece.offset + index);
    }
    CHECK(found == tasks);
    CHECK(array_pieces({}, most).empty());
}
