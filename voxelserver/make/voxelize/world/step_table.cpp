#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "voxelserver/make/voxelize/decks/bridges.hpp"
#include "voxelserver/make/voxelize/steps/ground_fill.hpp"
#include "voxelserver/make/voxelize/steps/runs.hpp"
#include "voxelserver/make/voxelize/steps/surface.hpp"
#include "voxelserver/make/voxelize/world/land.hpp"
#include "voxelserver/make/voxelize/world/step.hpp"

namespace terravox::voxelize {
namespace {

void find_water(Land& land) {
    land.water = fill_water(land.window, &land.water_access);
}

void take_seen_water(Land& land) {
    land.water = fill_water(land.window, nullptr);
}

void deepen(Land& land) {
    deepen_water(land.window, land.water_bodies(), land.shared.settings.water, land.shared.voxel_m,
                 land.water.value());
}

void level_beds(Land& land) {
    level_bed(land.shared.settings.water.min_depth_m, land.water.value());
}

void make_decks(Land& land) {
    const Settings& settings = land.shared.settings;
    WaterColumns& water = land.water.value();
    Decks decks;
    decks.found = find_decks(land.window, land.shared.points.classes(), land.water_bodies(),
                             settings.bridges, land.shared.voxel_m);
    if (decks.found)
        flow_beneath(*decks.found, settings.water.min_depth_m, water);
    decks.over = fill_decks(land.window, decks.found.get());
    land.decks = std::move(decks);
}

void take_seen_decks(Land& land) {
    land.decks = Decks{nullptr, seen_decks(land.window)};
}

void cover(Land& land) {
    const WaterColumns& water = land.water.value();
    const int radius = std::clamp(
        static_cast<int>(std::lround(Land::kWidestGap_m / land.shared.voxel_m)), 4, kWidestRadius);
    Margined<char> covered = straighten_rim(find_coverage(land.window, land.in_bounds, radius),
                                            land.in_bounds, std::min(radius / 4, kWidestRim));
    // A body of water belongs to the survey even if it returned few pulses.
    Margined<char>::each([&](int x, int z) {
        if (water.is_water(x, z) && land.in_bounds.at(x, z) != 0)
            covered.at(x, z) = 1;
    });
    land.covered = std::move(covered);
}

void lower_beneath_decks(Land& land) {
    if (const Decks& decks = land.decks.value(); decks.found)
        lower_ground(*decks.found, land.ground.value());
}

void interpolate_ground(Land& land) {
    const WaterColumns& water = land.water.value();
    const Margined<char>& covered = land.covered.value();
    Grid<char, GroundHeights::kMargin> wanted;
    GroundHeights::each([&](int x, int z) {
        wanted.at(x, z) = land.in_bounds.at(x, z) != 0 && !water.is_water(x, z) ? 1 : 0;
    });
    // A hole has no ground, and its edge needs none beyond it.
    Margined<char>::each([&](int x, int z) {
        wanted.at(x, z) = static_cast<char>(wanted.at(x, z) & covered.at(x, z));
    });
    land.ground = fill_ground(land.window, wanted, [&](std::int32_t x, std::int32_t z) {
        return land.shared.wide_ground.at(x, z, land.reach());
    });
    lower_beneath_decks(land);
}

void take_seen_ground(Land& land) {
    land.ground = seen_ground(land.window);
    lower_beneath_decks(land);
}

void close_roofs(Land& land) {
    land.roofs = fill_buildings(land.window, land.shared.settings.buildings, land.shared.voxel_m);
}

void take_seen_roofs(Land& land) {
    land.roofs = seen_roofs(land.window);
}

void grow_crowns(Land& land) {
    const StepContext& shared = land.shared;
    Margined<Crown> crowns = fill_crowns(land.window, shared.points.classes(), land.ground.value(),
                                         shared.settings, shared.voxel_m);
    if (const Decks& decks = land.decks.value(); decks.found)
        clear_crowns(*decks.found, shared.settings.vegetation.trunk_from_m, shared.voxel_m, crowns);
    land.crowns = std::move(crowns);
}

void take_no_crowns(Land& land) {
    land.crowns.emplace();
}

void find_buildings(Land& land) {
    land.buildings.emplace(land.window, land.shared.voxel_m);
}

void vary_colours(Land& land) {
    const StepContext& shared = land.shared;
    land.numbers =
        number_places(land.window, shared.points.classes(), land.buildings.value(),
                      land.roofs.value(), land.crowns.value(), shared.tints, shared.voxel_m);
}

void vary_no_colours(Land& land) {
    land.numbers.emplace();
}

// SurfaceStep itself leaves out the parts of both that are switched off.
void evaluate_surfaces(Land& land) {
    land.appearances = land.shared.surface.appearances(land.window);
}

void choose_surface(Land& land) {
    land.surface = land.shared.surface.surface(land.window, land.appearances.value());
}

void guess_materials(Land& land) {
    guess_roofs(land.window, land.shared.points.classes(), land.buildings.value(),
                land.shared.settings.material_guesses, land.surface.value());
}

void guess_nothing(Land& land) {
    static_cast<void>(land.buildings.value());
    static_cast<void>(land.surface.value());
}

void fill_columns(Land& land) {
    land.runs = make_runs(
        {land.window, land.shared.points.classes(), land.shared.settings, land.covered.value(),
         land.water.value(), land.ground.value(), land.roofs.value(), land.decks.value().over,
         land.crowns.value(), land.surface.value().material, land.surface.value().guessed,
         land.numbers.value(), land.shared.points.sources().floor_y, land.shared.voxel_m});
}

void cut_boxes(Land& land) {
    const PatchRuns& runs = land.runs.value();
    const SurfaceAppearance& surface = land.surface.value();
    const grid::PatchKey patch = land.window.middle;
    Boxes& out = land.boxes.emplace();
    if (runs.min_y() >= runs.max_y())
        return;
    out.by_begin = voxel::floor_div(runs.min_y(), voxel::kBoxSizeY);
    const std::int32_t end = voxel::floor_div(runs.max_y() - 1, voxel::kBoxSizeY) + 1;
    for (std::int32_t by = out.by_begin; by < end; ++by)
        out.boxes.push_back(serialize({0, patch.px, by, patch.pz}, runs, surface));
}

using namespace part;

constexpr Parts kAllOfColumns =
    kWater | kDecks | kCoverage | kGround | kRoofs | kCrowns | kSurface | kNumbers;

// The list of the steps. A step that always runs has no setting.
constexpr std::array kSteps{
    Step{kWaterEqualization, 0, kWater, find_water, take_seen_water},
    Step{kWaterDeepening, kWater, kWater, deepen, level_beds},
    Step{kBridges, kWater, kWater | kDecks, make_decks, take_seen_decks},
    Step{{"coverage", "finds out which columns belong to the survey"}, kWater, kCoverage, cover},
    Step{kGroundFill, kWater | kDecks | kCoverage, kGround, interpolate_ground, take_seen_ground},
    Step{kBuildingFill, 0, kRoofs, close_roofs, take_seen_roofs},
    Step{kVegetation, kDecks | kGround, kCrowns, grow_crowns, take_no_crowns},
    Step{{"buildings", "finds out which roofs are one building"}, 0, kBuildings, find_buildings},
    Step{kColourVariation, kBuildings | kRoofs | kCrowns, kNumbers, vary_colours, vary_no_colours},
    Step{kSpecialization, 0, kAppearances, evaluate_surfaces, evaluate_surfaces, true},
    Step{kNeighbourhoodFilters, kAppearances, kSurface, choose_surface, choose_surface},
    Step{kMaterialGuesses, kBuildings | kSurface, kSurface, guess_materials, guess_nothing},
    Step{
        {"underground fill", "fills columns from the rock up"}, kAllOfColumns, kRuns, fill_columns},
    Step{{"serialization", "cuts columns into boxes"}, kRuns | kSurface, kBoxes, cut_boxes},
};
static_assert(in_order(kSteps), "a step runs before one that makes what it reads");
static_assert(kSteps.size() <= 32, "Land::steps_done has a bit for each step");

constexpr std::uint32_t to_bit(std::size_t step) noexcept {
    return std::uint32_t{1} << step;
}

// From the last step to the first: the parts that a step reads must be made by those before it.
std::uint32_t steps_that_make(Parts wanted) noexcept {
    std::uint32_t out = 0;
    for (std::size_t i = kSteps.size(); i-- > 0;)
        if ((kSteps[i].makes & wanted) != 0) {
            out |= to_bit(i);
            wanted |= kSteps[i].reads;
        }
    return out;
}

void run_step(const Step& step, Land& land, util::StageTimes& times) {
    const bool on = step.about.on == nullptr || land.shared.settings.steps.*step.about.on;
    const auto run = on ? step.run : step.otherwise;
    if (step.reports_time) {
        run(land);
        return;
    }
    const util::StageTimes::Scope scope(times, std::string(step.about.name));
    run(land);
}

}  // namespace

std::span<const Step> steps() noexcept {
    return kSteps;
}

void run_steps(Land& land, Parts wanted, util::StageTimes& times) {
    const std::uint32_t needed = steps_that_make(wanted) & ~land.steps_done;
    for (std::size_t i = 0; i < kSteps.size(); ++i)
        if ((needed & to_bit(i)) != 0) {
            run_step(kSteps[i], land, times);
            land.steps_done |= to_bit(i);
        }
}

}  // namespace terravox::voxelize
