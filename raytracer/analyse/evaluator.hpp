#pragma once

#include <memory>

#include "raytracer/shade/shading.hpp"

namespace terravox::analyse {

/// What evaluates the rays of a view: light for pictures, else what its scene's analysis measures.
/// @param view must outlive the result
[[nodiscard]] std::unique_ptr<const shade::RayEvaluator> make_evaluator(const shade::View& view);

}  // namespace terravox::analyse
