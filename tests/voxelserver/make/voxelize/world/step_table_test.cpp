// The list of the steps: their order, and each of them by its name on a small piece of land.
#include <algorithm>
#include <optional>
#include <set>
#include <string>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/make/voxelize/world/box_column.hpp"
#include "voxelserver/make/voxelize/world/step.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

/// Flat ground with a house, a pond, a bridge and a wood, open for single patches.
class SmallLand {
public:
    SmallLand() {
        const auto file = m_folder.path() / "land.laz";
        Cloud cloud;
        cloud.cover(0, 0, 64, 64, 0.7, 2, [](double e, double n) {
            const bool house = e > 10 && e < 20 && n > 10 && n < 20;
            const bool pond = e > 30 && e < 50 && n > 30 && n < 50;
            return house || pond ? kNoHeight : 50.5;
        });
        cloud.cover(10, 10, 20, 20, 0.5, 6, [](double, double) { return 58.4; });
        cloud.cover(30, 30, 50, 50, 0.9, 9, [](double, double) { return 49.4; });
        cloud.cover(0, 54, 64, 58, 0.5, 17, [](double, double) { return 57.4; });
        cloud.cover(30, 8, 50, 24, 0.6, 5,
                    [](double e, double n) { return 60 + 4 * std::sin(e / 2) * std::sin(n / 3); });
        cloud.write(file);
        m_points.emplace(OpenWorld::with(file), m_settings, m_times);
        m_context.emplace(*m_points, nullptr, m_settings, std::size_t{64} << 20, m_times);
    }
    [[nodiscard]] StepContext& context() { return *m_context; }
    [[nodiscard]] util::StageTimes& times() { return m_times; }
    [[nodiscard]] Land fresh() { return Land(*m_context, patch()); }
    [[nodiscard]] static grid::PatchKey patch() { return {voxel_x(32) >> 6, voxel_z(32) >> 6}; }
    /// How often the step of that name has reported its time.
    [[nodiscard]] std::uint64_t count_runs(std::string_view name) const {
        for (const auto& stage : m_times.stages())
            if (stage.name == name)
                return stage.count;
        return 0;
    }

private:
    TemporaryFolder m_folder;
    util::StageTimes m_times;
    Settings m_settings;
    std::optional<PointSet> m_points;
    std::optional<StepContext> m_context;
};

/// The parts that are there.
Parts list_parts(const Land& land) {
    const auto bit = [](bool there, Parts part) { return there ? part : Parts{0}; };
    return bit(land.water.has_value(), part::kWater) | bit(land.decks.has_value(), part::kDecks) |
           bit(land.covered.has_value(), part::kCoverage) |
           bit(land.ground.has_value(), part::kGround) | bit(land.roofs.has_value(), part::kRoofs) |
           bit(land.crowns.has_value(), part::kCrowns) |
           bit(land.appearances.has_value(), part::kAppearances) |
           bit(land.surface.has_value(), part::kSurface) | bit(land.runs.has_value(), part::kRuns) |
           bit(land.boxes.has_value(), part::kBoxes) |
           bit(land.buildings.has_value(), part::kBuildings) |
           bit(land.numbers.has_value(), part::kNumbers);
}

std::vector<std::uint64_t> compute_checksums(const Boxes& boxes) {
    std::vector<std::uint64_t> out;
    for (const auto& box : boxes.boxes)
        out.push_back(box ? box->checksum() : 0);
    return out;
}

}  // namespace

TEST_CASE("every step has a name of its own, and every switch is one step's",
          "[voxelserver][voxelize][steps]") {
    std::set<std::string_view> names;
    std::vector<std::string_view> switched;
    for (const Step& step : steps()) {
        INFO(step.about.name);
        CHECK(names.insert(step.about.name).second);
        CHECK_FALSE(step.about.doc.empty());
        CHECK(step.run != nullptr);
        CHECK((step.about.on != nullptr) == (step.otherwise != nullptr));
        if (step.about.on != nullptr)
            switched.push_back(step.about.name);
    }
    std::vector<std::string_view> listed;
    for (const StepSwitch& step : kStepSwitches)
        listed.push_back(step.name);
    CHECK(switched == listed);
}

TEST_CASE("a table in which a step runs before what it reads is not in order",
          "[voxelserver][voxelize][steps]") {
    CHECK(in_order(steps()));
    std::size_t unordered = 0;
    for (std::size_t i = 0; i < steps().size(); ++i) {
        std::vector<Step> table(steps().begin(), steps().end());
        std::rotate(table.begin(), table.begin() + static_cast<std::ptrdiff_t>(i),
                    table.begin() + static_cast<std::ptrdiff_t>(i) + 1);
        INFO(table.front().about.name << " first");
        CHECK(in_order(table) == (table.front().reads == 0));
        unordered += in_order(table) ? 0 : 1;
    }
    CHECK(unordered == 10);
}

TEST_CASE("each step makes its parts from those that it names, switched on or off",
          "[voxelserver][voxelize][steps]") {
    SmallLand small;
    for (const Step& step : steps())
        for (const auto run : {step.run, step.otherwise}) {
            if (run == nullptr)
                continue;
            INFO(step.about.name << (run == step.run ? "" : ", switched off"));
            Land land = small.fresh();
            run_steps(land, step.reads, small.times());
            const Parts before = list_parts(land);
            CHECK((before & step.reads) == step.reads);
            REQUIRE_NOTHROW(run(land));
            CHECK(list_parts(land) == (before | step.makes));
        }
}

TEST_CASE("only the steps run that the wanted parts are made from, and each once",
          "[voxelserver][voxelize][steps]") {
    SmallLand small;
    Land land = small.fresh();
    run_steps(land, part::kRoofs, small.times());
    CHECK(list_parts(land) == part::kRoofs);
    run_steps(land, part::kGround, small.times());
    CHECK(list_parts(land) ==
          (part::kRoofs | part::kWater | part::kDecks | part::kCoverage | part::kGround));
    run_steps(land, part::kBoxes, small.times());
    for (const Step& step : steps()) {
        INFO(step.about.name);
        if (!step.reports_time)
            CHECK(small.count_runs(step.about.name) == 1);
    }
    const auto boxes = compute_checksums(*land.boxes);
    CHECK_FALSE(boxes.empty());
    run_steps(land, part::kBoxes, small.times());
    CHECK(small.count_runs("serialization") == 1);
    Land at_once = small.fresh();
    run_steps(at_once, part::kBoxes, small.times());
    CHECK(compute_checksums(*at_once.boxes) == boxes);
}
