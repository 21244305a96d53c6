#include "tests/bench/measure.hpp"

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::bench;

namespace {

/// An entry whose runs read 1, 2, 3, ...
Entry counting_entry(int& runs) {
    Entry out;
    out.name = "test/counting";
    out.prepare = [&runs](const Context&) -> Body {
        return [&runs](Readings& readings) { readings.add("run", "times", ++runs); };
    };
    return out;
}

struct Bench {
    ChildRunner children;
    test::TemporaryFolder folder;
    Context context{folder.path(), folder.path(), folder.path(), 1, children};
    std::atomic<bool> stop{false};
};

}  // namespace

TEST_CASE("median and spread of numbers in any order", "[bench][measure]") {
    struct Case {
        const char* name;
        std::vector<double> values;
        double median;
        double mad;
        double min;
        double max;
    };
    const auto c = GENERATE(values<Case>({
        {"one number", {4}, 4, 0, 4, 4},
        {"an odd count", {3, 1, 2}, 2, 1, 1, 3},
        {"an even count", {4, 1, 3, 2}, 2.5, 1, 1, 4},
        {"one bad run moves neither", {1, 1.5, 1, 1, 100}, 1, 0, 1, 100},
        {"negative numbers", {-1, -3, -2}, -2, 1, -3, -1},
    }));
    DYNAMIC_SECTION(c.name) {
        const Summary s = summarize(c.values);
        CHECK(s.median == Approx(c.median));
        CHECK(s.mad == Approx(c.mad));
        CHECK(s.min == c.min);
        CHECK(s.max == c.max);
        CHECK(s.count == c.values.size());
    }
}

TEST_CASE("there is no median of nothing", "[bench][measure]") {
    CHECK_THROWS_AS(measure_median({}), util::Error);
}

TEST_CASE("runs to warm up are made and not counted", "[bench][measure]") {
    Bench bench;
    int runs = 0;
    const Result result = measure(counting_entry(runs), bench.context, {2, 3}, bench.stop);
    CHECK(runs == 5);
    CHECK(result.status == Status::kMeasured);
    REQUIRE(result.metrics.size() == 1);
    CHECK(result.metrics[0].values == std::vector<double>{3, 4, 5});
}

TEST_CASE("an entry whose data are absent is skipped with its reason and not prepared",
          "[bench][measure]") {
    Bench bench;
    int runs = 0;
    Entry entry = counting_entry(runs);
    entry.missing = [](const Context&) { return std::string("no data"); };
    const Result result = measure(entry, bench.context, {1, 3}, bench.stop);
    CHECK(result.status == Status::kSkipped);
    CHECK(result.reason == "no data");
    CHECK(runs == 0);
}

TEST_CASE("a failure is a result, without numbers", "[bench][measure]") {
    Bench bench;
    int runs = 0;
    Entry entry = counting_entry(runs);
    SECTION("while preparing") {
        entry.prepare = [](const Context&) -> Body { throw util::Error("no such thing"); };
    }
    SECTION("in a later run") {
        entry.prepare = [&runs](const Context&) -> Body {
            return [&runs](Readings& readings) {
                readings.add("run", "times", 1);
                if (++runs == 3)
                    throw util::Error("no such thing");
            };
        };
    }
    const Result result = measure(entry, bench.context, {1, 3}, bench.stop);
    CHECK(result.status == Status::kFailed);
    CHECK(result.reason == "no such thing");
    CHECK(result.metrics.empty());
}

TEST_CASE("an interrupted entry has failed", "[bench][measure]") {
    Bench bench;
    bench.stop = true;
    int runs = 0;
    const Result result = measure(counting_entry(runs), bench.context, {1, 3}, bench.stop);
    CHECK(result.status == Status::kFailed);
    CHECK(result.reason == "interrupted");
    CHECK(runs == 0);
}

TEST_CASE("an exact entry runs once, and its notes are those of the last run", "[bench][measure]") {
    Bench bench;
    int runs = 0;
    Entry entry = counting_entry(runs);
    entry.exact = true;
    CHECK(measure(entry, bench.context, {3, 7}, bench.stop).metrics.at(0).values.size() == 1);
    CHECK(runs == 1);

    entry.exact = false;
    entry.prepare = [&runs](const Context&) -> Body {
        return [&runs](Readings& readings) {
            readings.note("run " + std::to_string(++runs));
            readings.add("error", "m", 0.5, at_most(0.2));
        };
    };
    const Result result = measure(entry, bench.context, {0, 2}, bench.stop);
    CHECK(result.notes == std::vector<std::string>{"run 3"});
    CHECK(result.metrics.at(0).target.bound == 0.2);
}

TEST_CASE("a metric keeps its unit", "[bench][measure]") {
    std::vector<Metric> metrics;
    Readings seconds;
    Readings milliseconds;
    seconds.add("time", "s", 1);
    milliseconds.add("time", "ms", 1000);
    add_readings(metrics, seconds);
    CHECK_THROWS_WITH(add_readings(metrics, milliseconds),
                      test::contains("in ms now, in s before"));
}
