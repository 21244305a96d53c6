#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "raytracer/analyse/raster/cell_file.hpp"

namespace terravox::analyse {

/// Cells of one kind.
struct SeenCells {
    std::uint64_t all = 0;   ///< with a value
    std::uint64_t seen = 0;  ///< by one observer or more
};

/// What of a raster of AnalysisKind::kSight is seen.
struct SightSummary {
    double cell_m2 = 1;
    SeenCells cells;
    std::uint64_t holes = 0;
    std::map<int, SeenCells> by_material;
    std::map<int, SeenCells> by_class;

    [[nodiscard]] double km2(std::uint64_t count) const noexcept {
        return static_cast<double>(count) * cell_m2 / 1e6;
    }
};

/// Counts the cells of a finished raster, block by block.
/// @param edge_m of a cell
/// @throws Error as CellFile
[[nodiscard]] SightSummary make_summary(CellFile& cells, double edge_m);

/// A table of a few lines: area, materials, classes.
[[nodiscard]] std::string make_table(const SightSummary& summary);
/// The same as one JSON object, in one line.
[[nodiscard]] std::string to_json(const SightSummary& summary);

}  // namespace terravox::analyse
