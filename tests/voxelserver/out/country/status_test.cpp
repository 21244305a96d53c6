#include "voxelserver/out/country/status.hpp"

#include <chrono>
#include <fstream>

#include "common/util/files.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/out/country/task.hpp"

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

TEST_CASE("times are written as people say them", "[country][status]") {
    CHECK(duration_text(45.2) == "45 s");
    CHECK(duration_text(720) == "12 min");
    CHECK(duration_text(11'520) == "3.2 h");
}

}  // namespace terravox::country
