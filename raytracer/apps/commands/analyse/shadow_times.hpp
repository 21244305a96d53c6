#pragma once

#include "raytracer/analyse/raster/cell_grid.hpp"
#include "raytracer/apps/commands/analyse/analyse_arguments.hpp"
#include "raytracer/farm/render/loaded_world.hpp"
#include "raytracer/farm/render/picture_renderer.hpp"

namespace terravox::commands {

/// Rejects options that masks of several instants cannot have.
/// @throws UsageError
void check_times_arguments(const AnalyseArguments& args);

/// Measures and writes shadow masks of several instants (`--times`), each rendered as a raster of
/// its own.
/// @param scene of the analysis, with its camera
/// @param loaded with a place on Earth
/// @return of all rasters together
/// @throws UsageError for an instant that is there twice; Error, also "interrupted"
[[nodiscard]] render::RenderStatistics write_shadow_times(const AnalyseArguments& args,
                                                          const scene::Scene& scene,
                                                          const analyse::CellGrid& grid,
                                                          const render::LoadedWorld& loaded,
                                                          render::PictureRenderer& renderer);

}  // namespace terravox::commands
