#include "common/util/error.hpp"
#include "tests/bench/accuracy/measures.hpp"
#include "tests/bench/accuracy/point_limits.hpp"
#include "tests/bench/accuracy/reclassed.hpp"
#include "tests/bench/bench.hpp"
#include "voxelserver/survey/survey.hpp"

namespace terravox::bench::accuracy_survey_entry {
namespace {

constexpr const char* kWork =
    "a synthetic survey of four squares of 1 km that meet in the middle of the place (seed 7, 8 "
    "pulses/m2), voxels of 1 m";

/// The survey's files, made once in a run of the bench, and its truth.
struct Surveyed {
    explicit Surveyed(const Context& c)
        : options(accuracy_survey(c.scratch / "accuracy-survey", c.threads)),
          truth(options, c.threads) {
        for (const auto& extent : survey::squares_of(options))
            files.push_back(options.folder / (extent.name() + ".laz"));
        if (!std::filesystem::exists(options.folder / "truth" / "place.json"))  // written last
            survey::run_survey(options, [](const survey::SquareReport&, std::size_t) {});
        width = fit_crown_width(truth.trees());
    }
    survey::SurveyOptions options;
    TruthPlace truth;
    std::vector<std::filesystem::path> files;
    CrownWidth width;
};

VoxelField voxels_of(const Surveyed& s, const std::vector<std::filesystem::path>& files,
                     const Context& c, bool photo) {
    voxelize::LidarWorldOptions options;
    options.files = files;
    if (photo)
        options.orthophotos = {s.options.folder / "ortho"};
    options.threads = c.threads;
    util::StageTimes times;
    const auto world = voxelize::open_lidar_world(options, times);
    return {*world, s.truth.area, c.threads};
}

Entry with_photo() {
    Entry out;
    out.name = "accuracy/survey";
    out.measures =
        "voxels against the truth: ground, buildings, overhangs, bridges, waters, trees, "
        "materials; what the points would allow";
    out.work = std::string(kWork) + ", with its orthophoto";
    out.missing = [](const Context&) { return std::string(); };
    out.exact = true;
    out.prepare = [](const Context& c) -> Body {
        return [s = std::make_shared<Surveyed>(c), &c](Readings& readings) {
            const VoxelField found = voxels_of(*s, s->files, c, true);
            measure_ground(s->truth, found, readings);
            measure_buildings(s->truth, found, readings);
            measure_overhangs(s->truth, found, readings);
            measure_bridges(s->truth, found, readings);
            measure_waters(s->truth, found, readings);
            measure_trees(s->truth, found, s->width, readings);
            measure_materials(s->truth, found, readings);
            add_point_limits(s->truth, read_point_columns(s->files, s->truth, c.threads), s->width,
                             readings);
        };
    };
    return out;
}

Entry without_photo() {
    Entry out;
    out.name = "accuracy/survey/no-photo";
    out.measures = "materials against the truth where there is no orthophoto";
    out.work = kWork;
    out.missing = [](const Context&) { return std::string(); };
    out.exact = true;
    out.prepare = [](const Context& c) -> Body {
        return [s = std::make_shared<Surveyed>(c), &c](Readings& readings) {
            measure_materials(s->truth, voxels_of(*s, s->files, c, false), readings);
        };
    };
    return out;
}

/// The points of bridges in a class other than that of bridges: their decks are to be recognised.
Entry without_bridge_class(const std::string& name, const std::string& as, std::uint8_t code) {
    Entry out;
    out.name = "accuracy/survey/no-bridge-class/" + name;
    out.measures = "bridges against the truth where their points are " + as;
    out.work = std::string(kWork) + ", class 17 made class " + std::to_string(code);
    out.missing = [](const Context&) { return std::string(); };
    out.exact = true;
    out.prepare = [name, code](const Context& c) -> Body {
        constexpr std::uint8_t kBridges = 17;
        auto s = std::make_shared<Surveyed>(c);
        const auto files =
            reclass(s->files, kBridges, code, c.scratch / ("accuracy-survey-" + name));
        return [s, files, &c](Readings& readings) {
            measure_bridges(s->truth, voxels_of(*s, files, c, false), readings);
        };
    };
    return out;
}

const Registration kRegistered([] {
    return std::vector{with_photo(), without_photo(), without_bridge_class("ground", "ground", 2),
                       without_bridge_class("unclassified", "unclassified", 1)};
});

}  // namespace
}  // namespace terravox::bench::accuracy_survey_entry
