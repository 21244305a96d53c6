#include "voxelserver/out/country/workload.hpp"

#include "tests/catch.hpp"

namespace terravox::country {
namespace {

constexpr std::int32_t kEdge = 512;

/// Squares of 1000 voxels, `across` x `down`, from the origin on.
std::vector<SurveySquare> squares(std::int32_t across, std::int32_t down, std::uint64_t points) {
    std::vector<SurveySquare> out;
    for (std::int32_t z = 0; z < down; ++z)
        for (std::int32_t x = 0; x < across; ++x)
            out.push_back({{x * 1000, z * 1000, (x + 1) * 1000, (z + 1) * 1000}, points});
    return out;
}

exports::Columns columns(std::int32_t across, std::int32_t down) {
    return {{0, 0, across, down}, 1, [](const exports::ColumnBlock&) { return true; }};
}

}  // namespace

TEST_CASE("a column of boxes reads the squares that its halo touches", "[country][workload]") {
    const Survey survey(squares(3, 3, 100), kEdge);
    CHECK(survey.read_by({0, 0, 0}) == std::vector<std::size_t>{0});
    CHECK(survey.read_by({1, 0, 0}) == std::vector<std::size_t>{0, 1});
    CHECK(survey.read_by({1, 1, 0}) == std::vector<std::size_t>{0, 1, 3, 4});
    // 64 voxels to the west begins another square: 1024 - 64 < 1000.
    CHECK(survey.read_by({2, 0, 0}) == std::vector<std::size_t>{0, 1});
    CHECK(survey.read_by({40, 40, 0}).empty());
}

TEST_CASE("squares cover a column of boxes once, even where they overlap", "[country][workload]") {
    std::vector<SurveySquare> some = squares(1, 1, 100);
    some.push_back(some.front());
    const Survey survey(some, kEdge);
    CHECK(survey.covered({0, 0, 0}) == 512.0 * 512.0);
    CHECK(survey.covered({1, 0, 0}) == 512.0 * 512.0);  // 488 twice, at most all
    CHECK(survey.covered({7, 0, 0}) == 0);
}

TEST_CASE("with room for all of them each square is decoded once", "[country][workload]") {
    const Survey survey(squares(3, 3, 1000), kEdge);
    const auto all = columns(6, 6);
    const Workload work = measure_workload(survey, all, 0, all.count(), 1 << 30);
    CHECK(work.columns == 36);
    CHECK(work.squares == 9);
    CHECK(work.points == 9000);
    CHECK(work.covered == 9'000'000);
    CHECK(work.scratch_bytes == 9 * 1000 * SurveySquare::kPoint_bytes);
}

TEST_CASE("without room squares are decoded for each row anew", "[country][workload]") {
    const Survey survey(squares(3, 3, 1000), kEdge);
    const auto all = columns(6, 6);
    const std::uint64_t two = 2 * 1000 * SurveySquare::kPoint_bytes;
    const Workload work = measure_workload(survey, all, 0, all.count(), two);
    CHECK(work.squares > 9);
    CHECK(work.scratch_bytes <= two);
}

TEST_CASE("shards decode what lies between them twice, and cover the whole together",
          "[country][workload]") {
    const Survey survey(squares(3, 3, 1000), kEdge);
    const auto all = columns(6, 6);
    double covered = 0;
    double points = 0;
    for (std::size_t shard = 0; shard < 6; ++shard) {
        const Workload work = measure_workload(survey, all, shard * 6, shard * 6 + 6, 1 << 30);
        covered += work.covered;
        points += work.points;
    }
    CHECK(covered == 9'000'000);
    CHECK(points > 9000);
}

}  // namespace terravox::country
