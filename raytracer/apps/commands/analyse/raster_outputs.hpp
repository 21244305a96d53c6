#pragma once

#include <optional>
#include <stop_token>
#include <string>

#include "raytracer/analyse/raster/derived_bands.hpp"
#include "raytracer/analyse/raster/sight_summary.hpp"
#include "raytracer/apps/commands/analyse/object_arguments.hpp"
#include "raytracer/apps/commands/analyse/report_arguments.hpp"

namespace terravox::commands {

/// How the slopes of a terrain raster are derived.
/// @throws UsageError for an even window, and for what is no direction of light
[[nodiscard]] analyse::ReliefOptions relief_of(const scene::Scene& scene);

/// What is made of the measured cells of a raster.
struct RasterOutputs {
    const std::string& file;  ///< GeoTIFF
    const ReportArguments& reports;
    const std::optional<PlannedObjects>& objects;
};

/// Derives the bands that depend on neighbours, and writes all files.
/// @param cells with all tiles
/// @param info metadata; the place of the raster is added
/// @param threads for compression
/// @return of an analysis of sight: what is seen
/// @throws Error, also "interrupted" when stopped; UsageError as relief_of()
[[nodiscard]] std::optional<analyse::SightSummary> write_outputs(
    analyse::CellFile& cells, const RasterOutputs& outputs, const Reported& what,
    output::PictureInfo info, int threads, const std::stop_token& stop);

}  // namespace terravox::commands
