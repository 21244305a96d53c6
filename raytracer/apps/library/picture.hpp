#pragma once

#include <cstddef>
#include <terravox/control.hpp>
#include <terravox/picture.hpp>

#include "raytracer/apps/library/state.hpp"
#include "raytracer/core/output/picture.hpp"
#include "raytracer/core/shade/view.hpp"

namespace terravox {

/// @throws util::UsageError
[[nodiscard]] scene::Scene make_scene(const SceneText& text);

/// Renders the tiles of a view on threads of this process.
/// @param film, sink what takes the tiles: a film, or something else that takes them in any order
/// @return boxes that could not be read
/// @throws Stopped, util::Error
std::size_t render_tiles(const WorldState& state, const shade::View& view, int threads,
                         const Control& control, output::Film& film);
std::size_t render_tiles(const WorldState& state, const shade::View& view, int threads,
                         const Control& control, output::TileSink& sink);

}  // namespace terravox
