#include <cmath>

#include "tests/catch.hpp"
#include "voxelserver/out/country/sample.hpp"

namespace terravox::country {

TEST_CASE("the error of a ratio grows with the differences, and ends with the whole",
          "[country][estimate]") {
    const std::vector<SizeAndValue> same{{1, 3}, {2, 6}, {5, 15}};
    const std::vector<SizeAndValue> unlike{{1, 5}, {1, 1}, {1, 3}};
    CHECK(measure_ratio(same, 100).value == Approx(3));
    CHECK(measure_ratio(same, 100).error == Approx(0).margin(1e-12));
    CHECK(measure_ratio(unlike, 100).value == Approx(3));
    CHECK(measure_ratio(unlike, 3).error == 0);
    // 2 standard errors: 2 sqrt((1 - 3/100) (4 + 4) / 2 / 3)
    CHECK(measure_ratio(unlike, 100).error == Approx(2 * std::sqrt(0.97 * 4 / 3)));
    // One measurement knows nothing of the others.
    CHECK(measure_ratio({{2, 6}}, 10).error == Approx(3));
    CHECK(measure_ratio({{2, 6}}, 1).error == 0);
    CHECK(measure_ratio({}, 10).value == 0);
    CHECK(measure_ratio({{0, 1}}, 10).value == 0);
}

TEST_CASE("an estimate is opening, decoding and making", "[country][estimate]") {
    Sample sample;
    sample.open_cpu_s = 1;
    sample.decoded = {{1000, 2, 0}, {1000, 2, 0}};
    sample.made = {{100, 5, 50}, {100, 5, 50}};
    sample.peak_mib = 300;
    Workload shard;
    shard.columns = 4;
    shard.covered = 400;
    shard.points = 3000;
    shard.squares = 3;
    Workload together = shard;
    together.columns = 8;
    together.covered = 800;
    together.points = 4000;
    const Estimate estimate = make_estimate(sample, {shard, shard}, together, 4);
    CHECK(estimate.cpu_s.value == Approx(2 * (1 + 6 + 20)));
    CHECK(estimate.one_machine_cpu_s.value == Approx(2 + 8 + 40));
    CHECK(estimate.output_bytes.value == Approx(400));
    CHECK(estimate.cpu_s.error == Approx(0).margin(1e-9));
    const PlannedShard one = planned(sample, shard, 2);
    CHECK(one.cpu_s == Approx(27));
    CHECK(one.subtrees == 8);
    CHECK(one.squares == 3);
}

TEST_CASE("the sample is spread over the order of columns", "[country][estimate]") {
    const exports::Columns columns({0, 0, 20, 20}, 1,
                                   [](const exports::ColumnBlock&) { return true; });
    const Survey survey({{{0, 0, 10'240, 10'240}, 100}}, 512);
    const auto chosen = columns_to_sample(survey, columns, 8);
    REQUIRE(chosen.size() == 8);
    for (std::size_t k = 0; k < chosen.size(); ++k) {
        CHECK(chosen[k] >= k * 50);
        CHECK(chosen[k] < (k + 1) * 50);
    }
    CHECK(columns_to_sample(survey, columns, 1000).size() == 400);
}

}  // namespace terravox::country
