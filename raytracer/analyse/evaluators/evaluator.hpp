#pragma once

#include <memory>

#include "raytracer/core/shade/shading.hpp"

namespace terravox::analyse {

/// What evaluates the rays of a view: light for pictures, else what its scene's analysis measures.
/// @param view must outlive the result
[[nodiscard]] std::unique_ptr<const shade::RayEvaluator> make_evaluator(const shade::View& view);

/// What thin things mean to the view's rays to sun and sky. What people stand in does not shade
/// them, and voxels make trunks and wires many times as wide: for light on the ground and on
/// facades they are passed, unless the scene says that they block. On the surface that is seen from
/// above, as for tools that know heights only, and in pictures, they always block.
[[nodiscard]] walk::ThinThings thin_things(const shade::View& view) noexcept;

}  // namespace terravox::analyse
