#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/voxel/material.hpp"
#include "voxelserver/data/imagery/colour_map.hpp"

namespace terravox::voxel {
class ByteWriter;
}

namespace terravox::imagery {

/// The materials of a rectangle of columns with a margin on each side, index = z * width + x. kAir
/// does not vote and never changes.
struct Grid {
    static constexpr std::uint8_t kFixed = 1;  ///< flag: votes, but never changes
    /// flag: may change, but never votes, not even after it has changed
    static constexpr std::uint8_t kSilent = 2;

    int width = 0, height = 0;  ///< including the margin
    int margin = 0;
    std::vector<voxel::Material> material;
    std::vector<std::uint8_t> flags;  ///< empty = 0 everywhere
};

/// One neighbourhood filter: a column whose material is in `of` takes the majority's material among
/// the surrounding columns, or, where `at_most_permille` is set, becomes `to` when too few
/// surrounding columns have its own material.
struct FilterRow {
    std::string name;
    MaterialSet of = 0;                 ///< the materials that may change
    MaterialSet by = 0;                 ///< the materials that vote; unused with at_most_permille
    std::optional<voxel::Material> to;  ///< nullopt = the majority's material
    /// [0.1, 20]; the voters are the disc around the column, including itself.
    double radius_m = 1;
    int at_least_permille = 500;  ///< share of the disc's votes required for the new material
    /// -1, or the maximum share of the disc's columns (silent ones included) that have the column's
    /// own material for it to count as isolated.
    int at_most_permille = -1;
};

/// The rows in order of execution; each reads the result of the previous one.
using Filters = std::vector<FilterRow>;

/// Reads the [[filter]] rows of config/palettes/<id>.toml, following `extends` (a file with rows of
/// its own replaces the base's).
/// @throws UsageError for an unknown id; Error for a bad file, naming field, value and allowed
/// range; at most 24 rows
[[nodiscard]] Filters load_filters(const std::string& id_or_path);

/// Adds all values that results depend on, for a fingerprint; not names.
void add_values(const Filters& filters, voxel::ByteWriter& out);

inline constexpr int kMaxMargin = 24;  ///< voxels

/// The radius of each row in voxels: lround(radius / voxel) in [1, 6]. Where the margin would
/// exceed kMaxMargin, the widest rows are narrowed, one voxel at a time, the last of equally wide
/// ones first.
[[nodiscard]] std::vector<int> list_radii(const Filters& filters, double voxel_m);

/// The distance in voxels from which the filters read, [0, kMaxMargin]: rows that read nothing that
/// an earlier row writes run in parallel, so that it is the longest chain of dependent rows, not
/// the sum of all.
[[nodiscard]] int measure_margin(const Filters& filters, double voxel_m);

/// Step "neighbourhood filters". The result inside the margin depends only on columns within
/// measure_margin(), so any two overlapping rectangles agree; the content of the margin itself is
/// unspecified. On equal votes in a disc the column keeps its material if that is among the
/// winners, else the lower number wins.
/// @throws Error when the grid's margin is narrower than measure_margin() or its sizes are
/// inconsistent
void apply_filters(Grid& grid, const Filters& filters, double voxel_m);

}  // namespace terravox::imagery
