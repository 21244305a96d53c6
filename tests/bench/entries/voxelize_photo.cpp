#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "tests/bench/accuracy/photo_mosaic_survey.hpp"
#include "tests/bench/clocks.hpp"
#include "tests/bench/entries/data_sets.hpp"
#include "voxelserver/voxelize/world/lidar_world.hpp"

namespace terravox::bench::voxelize_photo_entry {
namespace {

namespace fs = std::filesystem;

constexpr double kMostOverRaw = 1.5;

struct Case {
    const char* name;
    const char* what;
    std::size_t squares;
    double voxel_m;
};
/// With fine voxels most columns have no point, and shadows are many columns long.
constexpr Case kCases[] = {
    {"voxelize/photo", "nine squares of 256 m (8 pulses/m2), voxels of 1 m", 9, 1},
    {"voxelize/photo/fine", "a square of 256 m (8 pulses/m2), voxels of 0.25 m", 1, 0.25},
};

/// Opening the world and making all of its boxes once.
Cost all_boxes(const voxelize::LidarWorldOptions& options) {
    util::StageTimes times;
    std::size_t solid = 0;
    std::unique_ptr<voxelize::LidarWorld> world;
    const Cost out = cost_of([&] {
        world = voxelize::open_lidar_world(options, times);
        for (const voxel::BoxKey& key : box_keys(*world))
            solid += world->box(key) ? 1U : 0U;
    });
    if (solid == 0)
        throw util::Error("make the boxes of the survey: all of them are air");
    return out;
}

/// Removes what is known of the light of photographs from a cache folder.
void forget_lights(const fs::path& folder) {
    std::vector<fs::path> known;
    for (const auto& file : fs::recursive_directory_iterator(folder))
        if (file.path().filename().string().starts_with("light-"))
            known.push_back(file.path());
    if (known.empty())
        throw util::Error("forget the light of photographs in " + folder.string() +
                          ": nothing is known of it");
    for (const fs::path& file : known)
        fs::remove(file);
}

void measure(const Case& of, const Context& c, Readings& readings) {
    const PhotoMosaicSurvey survey = photo_mosaic_survey(c.scratch / "photo-mosaic", c.threads);
    const auto squares = static_cast<std::ptrdiff_t>(of.squares);
    voxelize::LidarWorldOptions raw;
    raw.files.assign(survey.points.begin(), survey.points.begin() + squares);
    raw.orthophotos.assign(survey.photos.begin(), survey.photos.begin() + squares);
    raw.voxel_m = of.voxel_m;
    raw.photo = "raw";
    raw.threads = 1;
    raw.cache_dir = c.scratch / "voxelize-photo";
    fs::remove_all(raw.cache_dir);  // of the other case
    fs::create_directories(raw.cache_dir);
    voxelize::LidarWorldOptions albedo = raw;
    albedo.photo = "albedo";
    static_cast<void>(all_boxes(albedo));  // prepares the squares

    const double raw_s = all_boxes(raw).cpu_s;
    const double known_s = all_boxes(albedo).cpu_s;
    forget_lights(albedo.cache_dir);
    const double found_s = all_boxes(albedo).cpu_s;
    readings.add("CPU: colours as taken", "s", raw_s);
    readings.add("CPU: albedo, the light found before", "s", known_s);
    readings.add("CPU: albedo, the light not known", "s", found_s);
    readings.add("albedo over colours as taken", "x", known_s / raw_s, at_most(kMostOverRaw));
    readings.add("finding the light over colours as taken", "x", (found_s - known_s) / raw_s);
}

Entry entry_of(const Case& of) {
    Entry out;
    out.name = of.name;
    out.measures = "what it costs to take the light out of photographs, compared with leaving it";
    out.work = std::string("all boxes of ") + of.what +
               ", each with a photograph of 0.5 m; squares prepared on disk; one thread";
    out.floor = "the same boxes with the photographs as they were taken";
    out.missing = [](const Context&) { return std::string(); };
    out.prepare = [of](const Context& c) -> Body {
        return [of, &c](Readings& readings) { measure(of, c, readings); };
    };
    return out;
}

const Registration kRegistered([] {
    std::vector<Entry> out;
    for (const Case& of : kCases)
        out.push_back(entry_of(of));
    return out;
});

}  // namespace
}  // namespace terravox::bench::voxelize_photo_entry
