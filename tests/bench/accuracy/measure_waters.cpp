#include <algorithm>
#include <cmath>

#include "tests/bench/accuracy/errors.hpp"
#include "tests/bench/accuracy/measures.hpp"

namespace terravox::bench {
namespace {

using survey::Vec2;
using voxel::Material;

bool is_water(Material m) {
    return m == Material::kWater;
}

/// How far a level lies outside the voxel that shows it: what is left of the error when its
/// rounding is taken off.
double beyond_voxel(int y, double level_m) {
    return level_m < y ? y - level_m : level_m > y + 1 ? y + 1 - level_m : 0;
}

/// The surface of one body of water, voxel by voxel.
struct Surface {
    Share wet;
    Errors level;
    Errors beyond;
    int lowest = 1 << 20;
    int highest = -(1 << 20);
    void add(const FoundRun* run, double level_m) {
        wet.add(run != nullptr);
        if (run == nullptr)
            return;
        const int y = run->y1 - 1;
        lowest = std::min(lowest, y);
        highest = std::max(highest, y);
        level.add(y + 0.5 - level_m);
        beyond.add(beyond_voxel(y, level_m));
    }
    [[nodiscard]] int unevenness() const { return std::max(0, highest - lowest); }
};

void measure_lakes(const TruthPlace& truth, const VoxelField& found, Readings& readings) {
    Surface all;
    double worst_level_m = 0;
    int worst_unevenness = 0;
    for (const survey::Site& site : truth.model.terrain().sites()) {
        if (!site.lake)
            continue;
        Surface lake;
        for (std::size_t i = 0; i < truth.area.size(); ++i) {
            const double level_m = static_cast<double>(truth.columns[i].water_m);
            const Vec2 p = truth.centre(i);
            if (std::abs(level_m - site.lake->level_m) > 1e-3 ||
                length(p - site.lake->centre) > site.lake->reach_m())
                continue;
            const FoundRun* const run = found.highest(i, is_water);
            lake.add(run, level_m);
            all.add(run, level_m);
        }
        if (lake.level.count() == 0)
            continue;
        worst_level_m = std::max(worst_level_m, lake.beyond.worst());
        worst_unevenness = std::max(worst_unevenness, lake.unevenness());
    }
    readings.add("lakes: worst level error beyond its voxel", "m", worst_level_m, at_most(0.2));
    readings.add("lakes: highest less lowest voxel", "voxels", worst_unevenness, at_most(0));
    readings.add("lakes: columns found as water", "share", all.wet.value());
}

/// A point of the course of running water with its true level.
struct Station {
    Vec2 at;
    double level_m;
};

/// Walks downstream, a metre at a time. @param stations those in the area that are wet
void measure_course(const std::string& name, const TruthPlace& truth, const VoxelField& found,
                    const std::vector<Station>& stations, Readings& readings) {
    Surface surface;
    std::size_t uphill = 0;
    std::ptrdiff_t last_column = -1;
    int last_y = 1 << 20;
    for (const Station& station : stations) {
        const std::ptrdiff_t column = truth.find_column(station.at);
        if (column < 0 || column == last_column)
            continue;
        last_column = column;
        const auto i = static_cast<std::size_t>(column);
        // Where the lake begins or the river takes the brook in, the level is not the brook's.
        if (std::abs(static_cast<double>(truth.columns[i].water_m) - station.level_m) > 0.05)
            continue;
        const FoundRun* const run = found.highest(i, is_water);
        surface.add(run, station.level_m);
        if (run == nullptr)
            continue;
        uphill += run->y1 > last_y ? 1U : 0U;
        last_y = run->y1;
    }
    readings.add(name + ": uphill steps", "steps", static_cast<double>(uphill), at_most(0));
    readings.add(name + ": level RMSE", "m", surface.level.rmse());
    readings.add(name + ": level RMSE beyond its voxel", "m", surface.beyond.rmse());
    readings.add(name + ": columns found as water", "share", surface.wet.value());
}

std::vector<Station> along(const survey::River& river, const survey::Box2& box) {
    std::vector<Station> out;
    for (double x = box.x0 + 0.5; x < box.x1; x += 1.0)
        out.push_back({{x, river.centre_y(x)}, river.level_m(x)});
    return out;
}

std::vector<Station> along(const survey::Brook& brook) {
    std::vector<Station> out;
    for (std::size_t i = 1; i < brook.line.size(); ++i) {
        const auto &a = brook.line[i - 1], &b = brook.line[i];
        const int steps = std::max(1, static_cast<int>(length(b.at - a.at)));
        for (int k = 0; k < steps; ++k) {
            const double part = static_cast<double>(k) / steps;
            out.push_back({a.at + (b.at - a.at) * part, survey::lerp(a.level_m, b.level_m, part)});
        }
    }
    return out;
}

}  // namespace

void measure_waters(const TruthPlace& truth, const VoxelField& found, Readings& readings) {
    measure_lakes(truth, found, readings);
    for (const survey::River& river : truth.model.terrain().rivers())
        if (river.index() == 0)
            measure_course("river", truth, found, along(river, truth.model.extent().box()),
                           readings);
    for (const survey::Site& site : truth.model.terrain().sites())
        if (site.brook)
            measure_course("brook", truth, found, along(*site.brook), readings);
}

}  // namespace terravox::bench
