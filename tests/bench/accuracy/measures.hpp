#pragma once

#include <algorithm>

#include "tests/bench/accuracy/truth_place.hpp"
#include "tests/bench/accuracy/voxel_field.hpp"
#include "tests/bench/bench.hpp"

/// Compares the voxels of a survey with its truth. Each function adds its readings, with a target
/// where they have one. Columns are those of 1 m; truth is taken at their centres.
/// Heights of voxels are those of their middles.
namespace terravox::bench {

inline constexpr double kMinTree_m = 3;  ///< lower plants are no trees
inline constexpr double kMinOpening_m =
    2;  ///< less air under a slab or deck need not show in voxels of 1 m

/// Under a slab that is high enough above the ground to show. @see kMinOpening_m
[[nodiscard]] inline bool tall_opening(const survey::TrueColumn& c) noexcept {
    return c.open_building &&
           static_cast<double>(c.underside_m) - static_cast<double>(c.ground_m) >= kMinOpening_m;
}

/// A bridge column at whose place the land reaches the deck: the abutments. It is neither deck nor
/// not.
[[nodiscard]] inline bool buried_deck(const survey::TrueColumn& c) noexcept {
    return c.deck_m > static_cast<float>(survey::kNoWater) &&
           c.deck_m - std::max(c.ground_m, c.water_m) < 1.0F;
}

/// The ground before quantization in the open, under crowns, and under buildings. Water is left
/// out.
void measure_ground(const TruthPlace& truth, const VoxelField& found, Readings& readings);
/// Footprints, heights of roofs, and where walls stand.
void measure_buildings(const TruthPlace& truth, const VoxelField& found, Readings& readings);
/// Air under balconies, carports, canopies and passages, and no air where a building reaches the
/// ground.
void measure_overhangs(const TruthPlace& truth, const VoxelField& found, Readings& readings);
/// Decks and what is open beneath them.
void measure_bridges(const TruthPlace& truth, const VoxelField& found, Readings& readings);
/// Lakes level and flat, rivers and brooks that never rise downstream.
void measure_waters(const TruthPlace& truth, const VoxelField& found, Readings& readings);
/// Trees by the voxelizer's own step, their heights, and crowns that nothing holds up.
void measure_trees(const TruthPlace& truth, const VoxelField& found, Readings& readings);
/// Without a truth: the share of leaves among what is beside the faces of walls and roofs, air or
/// leaves. Faces towards columns without anything do not count.
void measure_facades(const VoxelField& found, Readings& readings);
/// Without a truth: voxels of trunks for each column with leaves that are no low plants.
void measure_crowns(const VoxelField& found, Readings& readings);
/// The material of the highest voxel of each column against the true kind, with the table of both.
void measure_materials(const TruthPlace& truth, const VoxelField& found, Readings& readings);

}  // namespace terravox::bench
