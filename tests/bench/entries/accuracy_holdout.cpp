#include "tests/bench/accuracy/holdout.hpp"
#include "tests/bench/entries/data_sets.hpp"

namespace terravox::bench::accuracy_holdout_entry {
namespace {

constexpr int kNth = 10;

Entry entry_for(const DataSet& set, const std::string& crs) {
    Entry out;
    out.name = "accuracy/holdout/" + set.id;
    out.measures =
        "ground that the voxelizer did not see: predicted before quantization, bilinear between "
        "columns, against measured points";
    out.work = set.facts + ": every tenth ground point left out, the rest made a world";
    out.missing = [&set](const Context& c) { return set.missing(c); };
    out.exact = true;
    out.prepare = [&set, crs](const Context& c) -> Body {
        const auto folder = c.scratch / ("holdout-" + set.id);
        std::filesystem::create_directories(folder);
        const auto points =
            std::make_shared<std::vector<HeldOut>>(hold_out_ground(set.paths(c), folder, kNth));
        return [points, folder, crs, &set, &c](Readings& readings) {
            voxelize::LidarWorldOptions options;
            options.files = {folder};
            options.classes = set.classes.empty() ? "asprs" : set.classes;
            options.crs = crs;
            options.voxel_m = set.voxel_m;
            options.threads = c.threads;
            util::StageTimes times;
            const auto world = voxelize::open_lidar_world(options, times);
            std::size_t without = 0;
            const Errors errors = predict_held_out(*world, *points, without);
            readings.add("points left out", "points", static_cast<double>(points->size()));
            readings.add("of these beside unknown ground", "points", static_cast<double>(without));
            readings.add("RMSE", "m", errors.rmse());
            readings.add("bias", "m", errors.bias());
            readings.add("error, 50 %", "m", errors.size_at(0.5));
            readings.add("error, 95 %", "m", errors.size_at(0.95));
        };
    };
    return out;
}

const Registration kRegistered([] {
    return std::vector{entry_for(delft(), "EPSG:28992"), entry_for(montpellier(), "EPSG:2154"),
                       entry_for(square(), "EPSG:3794")};
});

}  // namespace
}  // namespace terravox::bench::accuracy_holdout_entry
