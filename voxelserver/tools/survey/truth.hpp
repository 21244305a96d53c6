#pragma once

#include <string>

#include "voxelserver/tools/survey/geotiff.hpp"
#include "voxelserver/tools/survey/square_model.hpp"
#include "voxelserver/tools/survey/survey_options.hpp"

namespace terravox::survey {

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
