#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "voxelserver/tools/survey/geotiff.hpp"
#include "voxelserver/tools/survey/square_model.hpp"
#include "voxelserver/tools/survey/survey.hpp"

namespace terravox::survey {

/// What is seen from above on a square metre. The numbers are those of truth/kind_NAME.tif: never
/// renumber.
enum class TrueKind : std::uint8_t {
    kGrass = 1,  ///< meadows, crops, gardens, scrub, the forest floor between crowns
    kBare = 2,   ///< rock, beach, ploughed fields, courtyards
    kRoad = 3,   ///< asphalt
    kGravelRoad = 4,
    kWater = 5,
    kTree = 6,  ///< crowns and bushes
    kRoofRed = 7,
    kRoofGrey = 8,
    kRoofPale = 9,
    kRoofCopper = 10,
    kBridge = 11,
    kWire = 12,
    kPylon = 13,
};
inline constexpr int kTrueKindCount = 14;
[[nodiscard]] const char* to_name(TrueKind) noexcept;

/// The truth at the centre of one square metre. Heights above sea level, metres; kNoWater where
/// there is none.
struct TrueColumn {
    static constexpr std::uint32_t kNone = ~0U;
    TrueKind kind = TrueKind::kGrass;  ///< of the highest object
    bool open_building = false;        ///< under a slab and in no building that reaches the ground
    /// Bare ground; the bed under water; under buildings as if they were not there.
    float ground_m = 0;
    float water_m = static_cast<float>(kNoWater);
    float roof_m = static_cast<float>(kNoWater);       ///< of the highest building
    float underside_m = static_cast<float>(kNoWater);  ///< of the lowest slab, with open_building
    float deck_m = static_cast<float>(kNoWater);       ///< of a bridge, parapet included
    float crown_m = static_cast<float>(kNoWater);      ///< of the highest crown
    std::uint32_t building = kNone;  ///< the highest; an index into the model's list
};

/// One column for each square metre of the model's square, north row first, at the pixel centres.
[[nodiscard]] std::vector<TrueColumn> true_columns(const SquareModel& model);

/// The true ground at 1 m, at the pixel centres: with roads, without bridges and buildings; the bed
/// under water.
[[nodiscard]] SquareRaster<float> true_ground(const SquareModel& model);

/// The kind of each square metre as seen from above (TrueKind), at the same pixels.
[[nodiscard]] SquareRaster<std::uint8_t> true_kinds(const SquareModel& model);

/// The contents of a square, as JSON: buildings, trees, water bodies, bridges, power line, and the
/// landmarks by name. Coordinates are easting and northing in metres rounded to 0.01, heights are
/// above sea level. Objects that straddle an edge are listed for both squares.
[[nodiscard]] std::string truth_json(const SquareModel& model);

/// Metadata of the survey as a whole: seed, squares, density, CRS, extents, versions.
[[nodiscard]] std::string place_json(const SurveyOptions& options);

/// Version of the layout of these JSON files.
inline constexpr int kTruthVersion = 2;

}  // namespace terravox::survey
