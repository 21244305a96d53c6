#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/voxel/material.hpp"

namespace terravox::voxel {
class ByteWriter;
}

namespace terravox::imagery {

/// The materials of a rectangle of columns with a margin on each side, index = z * width + x. kAir
/// has no vote and never changes.
struct Grid {
    static constexpr std::uint8_t kFixed = 1;  ///< flag: votes, but never changes
    static constexpr std::uint8_t kSilent =
        2;  ///< flag: may change, but has no vote, not even afterwards

    int width = 0, height = 0;  ///< with the margin
    int margin = 0;
    std::vector<voxel::Material> material;
    std::vector<std::uint8_t> flags;  ///< empty = 0 everywhere
};

/// One neighbourhood filter: a column of `of` becomes what the columns around it say, or, where
/// `at_most_permille` is set, what `to` says when too few columns around it are like it.
struct FilterRow {
    std::string name;
    std::uint32_t of = 0;               ///< the materials that may change, bit m for material m
    std::uint32_t by = 0;               ///< the materials that vote; unused with at_most
    std::optional<voxel::Material> to;  ///< nullopt = the majority's material
    double radius_m = 1;  ///< [0.1, 20]: the votes of the disc around the column, itself included
    int at_least_permille = 500;  ///< share of the disc's votes that the new material needs
    int at_most_permille = -1;    ///< -1, or the share of the disc's columns (silent ones too) with
                                  ///< the own material up to which it is isolated
};

/// Rows in the order in which they run; each reads what the one before left.
using Filters = std::vector<FilterRow>;

/// Reads the [[filter]] rows of config/palettes/<id>.toml, following `extends` (a file with rows of
/// its own replaces the base's).
/// @throws UsageError for an unknown id; Error for a bad file, naming field, value and allowed
/// range; at most 24 rows
[[nodiscard]] Filters load_filters(const std::string& id_or_path);

/// All that results depend on; not names.
void add_values(const Filters& filters, voxel::ByteWriter& out);

inline constexpr int kMaxMargin = 24;  ///< voxels

/// The radius of each row in voxels: lround(radius / voxel) in [1, 6], and where the margin would
/// be wider than kMaxMargin the widest rows are narrowed, one voxel at a time, the last of equals
/// first.
[[nodiscard]] std::vector<int> radii_of(const Filters& filters, double voxel_m);

/// How far the filters look, in voxels, [0, kMaxMargin]: rows that read nothing that an earlier
/// row writes run side by side, so it is the longest chain of rows, not the sum of all.
[[nodiscard]] int margin_of(const Filters& filters, double voxel_m);

/// Step "neighbourhood filters". What is left inside the margin depends on the columns within
/// margin_of() only, so any two rectangles agree; the margin itself is left as it may be. In a
/// disc, equal votes keep the column's material, else the lower number wins.
/// @throws Error when the grid's margin is narrower than margin_of() or its sizes disagree
void apply_filters(Grid& grid, const Filters& filters, double voxel_m);

}  // namespace terravox::imagery
