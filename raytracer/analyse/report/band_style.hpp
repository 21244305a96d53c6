#pragma once

#include <string>

#include "raytracer/analyse/evaluators/analysis.hpp"
#include "voxelserver/serve/map/pixels.hpp"

namespace terravox::analyse {

[[nodiscard]] constexpr bool has_categories(Ramp ramp) noexcept {
    return ramp == Ramp::kClasses || ramp == Ramp::kMaterials;
}

/// @param share of the scale, clamped to [0, 1]
[[nodiscard]] map::Rgba8 colour_at(Ramp ramp, double share) noexcept;

/// @param ramp one with categories
[[nodiscard]] map::Rgba8 colour_of_category(Ramp ramp, int number) noexcept;
[[nodiscard]] std::string name_of_category(Ramp ramp, int number);

}  // namespace terravox::analyse
