#include "common/util/error.hpp"
#include "tests/bench/accuracy/measures.hpp"
#include "tests/bench/bench.hpp"
#include "voxelserver/tools/survey/survey.hpp"

namespace terravox::bench::accuracy_survey_entry {
namespace {

/// The survey's files and its truth.
struct Surveyed {
    explicit Surveyed(const Context& c)
        : options(accuracy_survey(c.scratch / "accuracy-survey", c.threads)),
          truth(options, c.threads) {
        for (const auto& extent : survey::list_squares(options))
            files.push_back(options.folder / (extent.name() + ".laz"));
        survey::run_survey(options, [](const survey::SquareReport&, std::size_t) {});
    }
    survey::SurveyOptions options;
    TruthPlace truth;
    std::vector<std::filesystem::path> files;
};

VoxelField list_voxels(const Surveyed& s, const Context& c) {
    voxelize::LidarWorldOptions options;
    options.files = s.files;
    options.orthophotos = {s.options.folder / "ortho"};
    options.threads = c.threads;
    util::StageTimes times;
    const auto world = voxelize::open_lidar_world(options, times);
    return {*world, s.truth.area, c.threads};
}

Entry entry() {
    Entry out;
    out.name = "accuracy/survey";
    out.measures =
        "voxels against the truth: ground, buildings, overhangs, bridges, waters, trees, materials";
    out.work =
        "a synthetic survey of four squares of 1 km that meet in the middle of the place (seed 7, "
        "8 pulses/m2), with its orthophoto, voxels of 1 m";
    out.missing = [](const Context&) { return std::string(); };
    out.exact = true;
    out.prepare = [](const Context& c) -> Body {
        return [s = std::make_shared<Surveyed>(c), &c](Readings& readings) {
            const VoxelField found = list_voxels(*s, c);
            measure_ground(s->truth, found, readings);
            measure_buildings(s->truth, found, readings);
            measure_overhangs(s->truth, found, readings);
            measure_bridges(s->truth, found, readings);
            measure_waters(s->truth, found, readings);
            measure_trees(s->truth, found, readings);
            measure_materials(s->truth, found, readings);
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::accuracy_survey_entry
