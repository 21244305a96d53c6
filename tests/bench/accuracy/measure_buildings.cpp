#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "tests/bench/accuracy/errors.hpp"
#include "tests/bench/accuracy/measures.hpp"

namespace terravox::bench {
namespace {

using survey::TrueColumn;
using voxel::Material;

/// The columns next to one, as indices, within the area.
template <class Visit>
void for_each_next(const Area& area, std::size_t index, const Visit& visit) {
    const int column = static_cast<int>(index % static_cast<std::size_t>(area.width));
    const int row = static_cast<int>(index / static_cast<std::size_t>(area.width));
    for (const auto& [dc, dr] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}})
        if (area.holds(column + dc, row + dr))
            visit(area.index(column + dc, row + dr));
}

int to_floor(double metres) {
    return static_cast<int>(std::floor(metres));
}

/// Where the foot of the wall of a column can be seen: over its own ground, or over the lowest
/// ground next to it outside of any building.
/// @return the y of the lowest voxel that should be wall; nothing for a column that no side of can
/// be seen
std::optional<int> true_foot(const TruthPlace& truth, const VoxelField& found, std::size_t i) {
    std::optional<int> outside;
    for_each_next(truth.area, i, [&](std::size_t n) {
        const TrueColumn& next = truth.columns[n];
        if (next.building != TrueColumn::kNone || next.water_m > survey::kNoWater ||
            found.lowest(n, is_building) != nullptr)
            return;
        const int y = to_floor(static_cast<double>(next.ground_m)) + 1;
        outside = std::min(outside.value_or(y), y);
    });
    if (!outside)
        return std::nullopt;
    return std::max(*outside, to_floor(static_cast<double>(truth.columns[i].ground_m)) + 1);
}

bool rests_on_something(const VoxelField& found, std::size_t i, const FoundRun& wall) {
    const auto runs = found.runs(i);
    return std::any_of(runs.begin(), runs.end(),
                       [&](const FoundRun& run) { return run.y1 == wall.y0; });
}

}  // namespace

void measure_buildings(const TruthPlace& truth, const VoxelField& found, Readings& readings) {
    Overlap footprints;
    Errors roofs;
    Share feet;
    Share gapless;
    std::unordered_map<std::uint32_t, std::pair<double, double>>
        ridges;  // of each building: highest found and true height
    for (std::size_t i = 0; i < truth.area.size(); ++i) {
        const TrueColumn& real = truth.columns[i];
        const FoundRun* const top = found.highest(i, is_building);
        const bool built = real.building != TrueColumn::kNone;
        footprints.add(top != nullptr, built);
        if (!built || top == nullptr)
            continue;
        const double top_m = top->y1 - 0.5;
        roofs.add(top_m - static_cast<double>(real.roof_m));
        auto& ridge = ridges.try_emplace(real.building, -1e9, -1e9).first->second;
        ridge = {std::max(ridge.first, top_m),
                 std::max(ridge.second, static_cast<double>(real.roof_m))};
        if (real.open_building)
            continue;
        const auto foot = true_foot(truth, found, i);
        if (!foot)
            continue;
        const FoundRun& wall = *found.lowest(i, is_building);
        gapless.add(rests_on_something(found, i, wall));
        feet.add(std::abs(wall.y0 - *foot) <= 1 && rests_on_something(found, i, wall));
    }
    Errors tops;
    for (const auto& [number, ridge] : ridges)
        tops.add(ridge.first - ridge.second);
    readings.add("building footprint IoU", "", footprints.iou(), at_least(0.9));
    readings.add("roof height RMSE", "m", roofs.rmse());
    readings.add("roof height error, 95 %", "m", roofs.size_at(0.95));
    readings.add("ridge height RMSE", "m", tops.rmse());
    readings.add("wall base within 1 voxel of the ground", "share", feet.value(), at_least(0.99));
    readings.add("wall base without a gap", "share", gapless.value());
}

void measure_overhangs(const TruthPlace& truth, const VoxelField& found, Readings& readings) {
    // Air directly below a run of building: its height, or 0.
    const auto opening = [&](std::size_t i) {
        const auto runs = found.runs(i);
        for (std::size_t k = 1; k < runs.size(); ++k)
            if (is_building(runs[k].material))
                return static_cast<int>(runs[k].y0) - static_cast<int>(runs[k - 1].y1);
        return 0;
    };
    Share open;
    Share seen;
    Share hollow;
    for (std::size_t i = 0; i < truth.area.size(); ++i) {
        const TrueColumn& real = truth.columns[i];
        if (tall_opening(real)) {
            const bool built = found.lowest(i, is_building) != nullptr;
            seen.add(built);
            open.add(built && opening(i) >= kMinOpening_m);
        } else if (real.building != TrueColumn::kNone && !real.open_building) {
            hollow.add(opening(i) > 0);
        }
    }
    readings.add("overhang: columns with the slab", "share", seen.value());
    readings.add("overhang: columns open beneath the slab", "share", open.value());
    readings.add("closed buildings: columns with air beneath", "share", hollow.value());
}

void measure_bridges(const TruthPlace& truth, const VoxelField& found, Readings& readings) {
    const auto is_deck = [](Material m) { return m == Material::kBridge; };
    Overlap decks;
    Share open;
    Errors heights;
    for (std::size_t i = 0; i < truth.area.size(); ++i) {
        const TrueColumn& real = truth.columns[i];
        if (buried_deck(real))
            continue;
        const bool deck = real.deck_m > survey::kNoWater;
        const FoundRun* const lowest = found.lowest(i, is_deck);
        decks.add(lowest != nullptr, deck);
        if (!deck || lowest == nullptr)
            continue;
        heights.add(found.highest(i, is_deck)->y1 - 0.5 - static_cast<double>(real.deck_m));
        // The deck's own voxel hides a metre of what is below.
        const double below_m = static_cast<double>(std::max(real.ground_m, real.water_m));
        if (static_cast<double>(real.deck_m) - survey::kParapet_m - below_m >= kMinOpening_m)
            open.add(!rests_on_something(found, i, *lowest));
    }
    readings.add("bridge deck IoU", "", decks.iou(), at_least(0.8));
    readings.add("bridge: columns open beneath", "share", open.value(), at_least(0.95));
    readings.add("bridge deck height RMSE", "m", heights.rmse());
}

}  // namespace terravox::bench
