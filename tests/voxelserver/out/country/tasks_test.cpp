#include <chrono>
#include <cmath>
#include <fstream>
#include <numeric>
#include <set>

#include "common/util/files.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/out/country/sample.hpp"
#include "voxelserver/out/country/status.hpp"
#include "voxelserver/out/country/task.hpp"
#include "voxelserver/out/country/workload.hpp"

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

namespace terravox::country {
namespace {

using test::contains;

/// A plan of three shards of four steps each.
struct Stage {
    Stage() : folder(place.path()) {
        plan.world.inputs = {"/data"};
        plan.fingerprint = "f";
        plan.bounds = {{0, 0, 0}, {1, 1, 1}};
        for (int i = 0; i < 3; ++i)
            plan.shards.push_back({1, 4, 1, 100, 0});
        folder.make_folders();
    }
    /// A journal as a conversion writes it.
    void begin(int number, const std::string& job, const std::string& lines) const {
        std::ofstream(folder.shard(number).string() + ".journal")
            << job << " shard " << number << " of 3\n"
            << lines;
    }
    void record(int number, TaskRecord::State state, const std::string& error) const {
        TaskRecord out;
        out.plan = plan.id();
        out.state = state;
        out.error = error;
        out.host = "node7";
        out.begun = std::chrono::duration_cast<std::chrono::seconds>(
                        std::chrono::system_clock::now().time_since_epoch())
                        .count() -
                    50;
        write_record(folder.record(number), out);
    }

    test::TemporaryFolder place;
    PlanFolder folder;
    Plan plan;
};

}  // namespace

TEST_CASE("nothing is done of a new plan", "[country][status]") {
    const Stage stage;
    const CountryStatus status = find_status(stage.folder, stage.plan);
    CHECK(status.count(TaskState::kWaiting) == 3);
    CHECK(status.share == 0);
    CHECK_FALSE(status.left_s);
}

TEST_CASE("a lock says that a task runs, its journal how far it is", "[country][status]") {
    const Stage stage;
    stage.begin(2, stage.plan.job(), "\n5 6 0/0/0/0 ;\n5 6 0/1/0/0 ;\n7 8 0/2");
    stage.record(2, TaskRecord::State::kRunning, "");
    CHECK(find_status(stage.folder, stage.plan).count(TaskState::kRunning) == 0);
    const auto lock = util::FileLock::try_take(stage.folder.lock(2));
    const CountryStatus status = find_status(stage.folder, stage.plan);
    CHECK(status.tasks[1].state == TaskState::kRunning);
    CHECK(status.tasks[1].share == 0.5);
    CHECK(status.share == Approx(0.5 / 3));
    // 50 of 300 seconds of the plan took 50 seconds.
    REQUIRE(status.left_s);
    CHECK(*status.left_s == Approx(250).epsilon(0.1));
    CHECK_THAT(to_text(status, stage.plan), contains("shard 2: running on node7, 50 %"));
}

TEST_CASE("journals and records of another plan say nothing", "[country][status]") {
    const Stage stage;
    stage.begin(1, "terravox country of another", "\n5 6 0/0/0/0 ;\n");
    Plan other = stage.plan;
    other.fingerprint = "g";
    stage.record(1, TaskRecord::State::kFailed, "disk full");
    CHECK(find_status(stage.folder, other).count(TaskState::kFailed) == 0);
    CHECK(find_status(stage.folder, stage.plan).tasks[0].share == 0);
    CHECK(find_status(stage.folder, stage.plan).tasks[0].error == "disk full");
}

TEST_CASE("files that are no shards and no records are not taken for such", "[country][status]") {
    const Stage stage;
    std::ofstream(stage.folder.shard(1)) << "no shard";
    std::ofstream(stage.folder.record(1)) << "{\"plan\": 7";
    std::ofstream(stage.folder.record(2)) << "[]";
    CHECK(find_status(stage.folder, stage.plan).count(TaskState::kWaiting) == 3);
}

}  // namespace terravox::country
