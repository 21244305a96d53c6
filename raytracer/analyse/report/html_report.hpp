#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/analyse/raster/cell_file.hpp"

namespace terravox::analyse {

/// What a report says in addition to the values. UTF-8.
struct ReportFacts {
    core::AnalysisKind kind = core::AnalysisKind::kNone;
    std::string place;        ///< title of the world
    std::string attribution;  ///< empty: unknown, as below
    std::string licence;
    std::string crs;
    double cell_m = 1;  ///< edge of a cell
    std::size_t missing_boxes = 0;
    std::vector<std::pair<std::string, std::string>> settings;  ///< names and values
};

/// Writes a page with a map of each band that has a style, and a table of all bands. It is one file
/// that needs no network, and holds no script.
/// @param cells of an analysis of facts.kind
/// @throws Error "interrupted" when stopped; Error when it cannot be written
void write_report(CellFile& cells, const std::filesystem::path& out, const ReportFacts& facts,
                  const std::stop_token& stop);

/// Writes the map of the analysis' first band that has a style, with its legend, as an SVG file.
/// @throws as write_report()
void write_map(CellFile& cells, const std::filesystem::path& out, const ReportFacts& facts,
               const std::stop_token& stop);

/// @param ending ".html" or ".svg"
/// @throws UsageError unless the file's name has the ending; Error when it cannot be written
void check_report_target(const std::filesystem::path& out, const std::string& ending);

}  // namespace terravox::analyse
