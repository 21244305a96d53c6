#include <fstream>
#include <limits>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/out/country/join.hpp"
#include "voxelserver/out/country/plan.hpp"
#include "voxelserver/out/country/task.hpp"

namespace terravox::country {
namespace {

Plan some_plan() {
    Plan plan;
    plan.program = "1.2.3";
    plan.box_recipe = 4;
    plan.world.inputs = {"/data/survey"};
    plan.world.orthophotos = {"/data/photos"};
    plan.world.left_out = {"/data/survey/x.laz"};
    plan.world.title = "survey";
    plan.world.crs = "EPSG:3794";
    plan.world.voxel_m = 0.1;
    plan.world.memory_bytes = std::size_t{512} << 20;
    plan.area = {1, 2.5, 3, 4};
    plan.heights = {-3, 1200.5};
    plan.fingerprint = "0123456789abcdef0123456789abcdef";
    plan.crs = "EPSG:3794";
    plan.voxel_m = 0.1;
    plan.bounds = {{-5, 0, -7}, {5, 300, 7}};
    plan.squares = {{"/data/survey/a.laz", 10, 20, "ab"}};
    plan.images = {{"/data/photos/a.tif", 30, 0, "cd"}};
    plan.missing = {{"x", "it is damaged"}};
    plan.scratch_bytes = 1 << 20;
    plan.shards = {{1, 2, 3, 4.25, 5}, {6, 7, 8, 9.5, 10}};
    plan.estimate = {3, {1.5, 0.25}, {1.25, 0.125}, 77, {1e9, 1e7}};
    return plan;
}

}  // namespace

TEST_CASE("a plan is read as it was written", "[country][plan]") {
    const test::TemporaryFolder place;
    const PlanFolder folder(place.path());
    const Plan plan = some_plan();
    write_plan(folder, plan);
    const Plan read = read_plan(folder);
    CHECK(read.id() == plan.id());
    CHECK(read.world.inputs == plan.world.inputs);
    CHECK(read.missing.front().reason == "it is damaged");
    CHECK(read.estimate.output_bytes.error == 1e7);
    REQUIRE(read.shards.size() == 2);
    CHECK(read.shards[1].cpu_s == 9.5);
    const std::string written = test::read_content(folder.plan());
    write_plan(folder, read);
    CHECK(test::read_content(folder.plan()) == written);
}

TEST_CASE("what shards are made of has a name of its own", "[country][plan]") {
    const Plan plan = some_plan();
    const auto differs = [&](const auto& change) {
        Plan other = plan;
        change(other);
        return other.id() != plan.id();
    };
    CHECK(differs([](Plan& p) { p.program = "1.2.4"; }));
    CHECK(differs([](Plan& p) { ++p.box_recipe; }));
    CHECK(differs([](Plan& p) { p.fingerprint.back() = 'e'; }));
    CHECK(differs([](Plan& p) { ++p.bounds.max[2]; }));
    CHECK(differs([](Plan& p) { p.shards.pop_back(); }));
    CHECK(differs([](Plan& p) { p.world.title = "another"; }));
    CHECK_FALSE(differs([](Plan& p) { p.estimate = {}; }));
    CHECK_FALSE(differs([](Plan& p) { p.world.memory_bytes = 1; }));
}

TEST_CASE("a plan that is no plan is refused with a line", "[country][plan]") {
    const test::TemporaryFolder place;
    const PlanFolder folder(place.path());
    CHECK_THROWS_AS(read_plan(folder), util::UsageError);
    for (const char* text : {"", "{", "[]", "7", "{}", R"({"format": 1})", R"({"format": "1"})",
                             R"({"format": 1, "program": 7})"}) {
        CAPTURE(text);
        std::ofstream(folder.plan()) << text;
        CHECK_THROWS_AS(read_plan(folder), util::Error);
    }
    CHECK_THROWS_AS(PlanFolder(place.path() / "none"), util::UsageError);
}

TEST_CASE("a plan with numbers that no world has is refused", "[country][plan]") {
    struct Case {
        const char* name;
        void (*change)(Plan&);
        const char* said;
    };
    constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();
    const auto c = GENERATE_COPY(values<Case>({
        {"far bounds", [](Plan& p) { p.bounds.max[0] = kFar; }, "bounds lie beyond"},
        {"no voxels", [](Plan& p) { p.voxel_m = 0; }, "voxel_m = 0.000000; allowed"},
        {"huge voxels", [](Plan& p) { p.world.voxel_m = 1e9; }, "voxel_m = 1000000000"},
        {"no memory", [](Plan& p) { p.world.memory_bytes = 0; }, "memory_mib = 0; allowed"},
        {"all memory", [](Plan& p) { p.world.memory_bytes = std::size_t{1} << 60; },
         "allowed: 1 to 1048576"},
        {"one height", [](Plan& p) { p.heights.pop_back(); }, "its heights are 1 numbers"},
        {"half an area", [](Plan& p) { p.area.pop_back(); }, "its area has 3 numbers"},
    }));
    DYNAMIC_SECTION(c.name) {
        const test::TemporaryFolder place;
        const PlanFolder folder(place.path());
        Plan plan = some_plan();
        c.change(plan);
        write_plan(folder, plan);
        CHECK_THROWS_WITH(read_plan(folder), test::contains(c.said));
    }
}

TEST_CASE("a run goes on where its plan's folder is, and elsewhere only when that is named",
          "[country][plan]") {
    namespace fs = std::filesystem;
    const test::TemporaryFolder place;
    fs::create_directory(place.path() / "plan");
    fs::create_directory(place.path() / "disk");
    const PlanFolder folder(place.path() / "plan");
    const fs::path at = folder.path().parent_path();
    fs::create_symlink("../disk/a.tvx", at / "plan" / "inner.tvx");
    fs::create_symlink("disk/a.tvx", at / "outer.tvx");
    const auto confirmed = [&](const fs::path& archive, const fs::path& named) {
        return confirmed_archive(folder, {"id", archive, "", "", ""}, named, "resume the plan");
    };
    for (const fs::path& near : {at / "plan" / "a.tvx", at / "a.tvx"}) {
        CAPTURE(near);
        CHECK(confirmed(near, "") == near);
    }
    for (const fs::path& far :
         {at / "disk" / "a.tvx", at / "plan" / "deeper" / "a.tvx", at.parent_path() / "a.tvx",
          at / "plan" / ".." / ".." / "a.tvx", at / "plan" / "inner.tvx", at / "outer.tvx",
          at / "notes.txt", at / ".profile", fs::path("/etc/a.tvx"), fs::path("a.tvx"),
          fs::path()}) {
        CAPTURE(far);
        CHECK_THROWS_WITH(confirmed(far, ""),
                          test::contains("resume the plan: its run.json names " + far.string()) &&
                              test::contains("allowed: -o " + far.string()));
        CHECK_THROWS_AS(confirmed(far, ""), util::UsageError);
    }
    CHECK(confirmed(at / "disk" / "a.tvx", at / "disk" / "a.tvx") == at / "disk" / "a.tvx");
    CHECK(confirmed(at / "disk" / "a.tvx", at / "plan" / ".." / "disk" / "a.tvx") ==
          at / "disk" / "a.tvx");
    CHECK_THROWS_WITH(confirmed(at / "a.tvx", at / "b.tvx"),
                      test::contains("its run writes " + (at / "a.tvx").string()));
}

TEST_CASE("links in the folder of a plan lead no task to what lies elsewhere", "[country][plan]") {
    namespace fs = std::filesystem;
    const test::TemporaryFolder place;
    const fs::path at = place.path();
    fs::create_directory(at / "plan");
    fs::create_directory(at / "mine");
    std::ofstream(at / "mine" / "precious") << "as it was";
    const Plan plan = some_plan();
    {
        const PlanFolder folder(at / "plan");
        folder.make_folders();
        fs::create_symlink(at / "mine" / "precious", folder.plan());
        write_plan(folder, plan);
        CHECK(fs::is_regular_file(fs::symlink_status(folder.plan())));
        fs::create_symlink(at / "mine" / "precious", folder.shard(1));
        CHECK_THROWS_WITH(make_shard(folder, plan, 1, {}),
                          test::contains("00001.tvx is a symbolic link"));
        fs::create_symlink(at / "mine" / "precious", folder.lock(2));
        CHECK_THROWS_WITH(make_shard(folder, plan, 2, {}),
                          test::contains("00002.lock is a symbolic link"));
    }
    fs::create_directory_symlink(at / "mine", at / "plan" / "scratch");
    CHECK_THROWS_WITH(PlanFolder(at / "plan"), test::contains("scratch is a symbolic link"));
    CHECK(fs::file_size(at / "mine" / "precious") == 9);
}

}  // namespace terravox::country
