#pragma once

#include <optional>

#include "common/geo/lat_lon.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::solar {

/// The place whose sun is that of a scene: of an analysis analysis.place, else the middle of the
/// world.
/// @param centre of the world; nullopt where it is not georeferenced
/// @throws UsageError for an analysis.place that is not on Earth
[[nodiscard]] std::optional<geo::MapPlace> place_of(const scene::Scene& scene,
                                                    const std::optional<geo::MapPlace>& centre);

}  // namespace terravox::solar
