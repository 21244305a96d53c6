#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "voxelserver/out/country/plan.hpp"

namespace terravox::country {

struct PlanOptions {
    worlds::WorldOptions world;
    std::vector<double> area;     ///< as exports::Selection
    std::vector<double> heights;  ///< as exports::Selection
    int shards = 0;               ///< 0: so many that each takes about kUsualTask_s
    std::size_t sample = 6;       ///< columns of boxes to measure
    std::uint64_t scratch_bytes = std::uint64_t{2} << 30;
    std::filesystem::path scratch;  ///< folder for the squares of the sample; it is removed
    static constexpr double kUsualTask_s = 900;
};

struct PlannedCountry {
    Plan plan;
    std::string known_squares;  ///< bytes of PlanFolder::known_squares()
};

/// Plans a country: looks at all inputs, opens the world of those that can be read, measures some
/// places, and foresees the rest.
/// @param progress called with the places that were measured, and all of them
/// @throws UsageError for inputs and options that do not apply; Error when the world cannot be
/// opened
[[nodiscard]] PlannedCountry make_plan(
    const PlanOptions& options, const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace terravox::country
