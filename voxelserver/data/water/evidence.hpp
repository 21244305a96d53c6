#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/data/water/body_levels.hpp"
#include "voxelserver/data/water/water_cells.hpp"

namespace terravox::water {

/// Criteria for water. Lengths and heights in metres.
struct Evidence {
    /// (a) Connected open cells with water returns are water: LiDAR pulses are mostly absorbed
    /// there, so the voids around them are water too.
    bool by_class = true;
    /// (b) Cells that look wet and form a flat body are water, missed by the classification.
    bool by_photo = true;
    bool by_void = true;  ///< (c) voids within a flat shore are water

    /// (a) Minimum in a body: a single misclassified return must not make a lake.
    std::uint32_t fewest_returns = 3;
    double min_wet_m2 = 200;   ///< (b)
    double flat_wet_m = 0.4;   ///< (b) maximum spread of the middle 80 % of levels
    double min_void_m2 = 150;  ///< (c)
    /// (c) Maximum spread of the lower half of the shore heights, and between its four sides.
    double flat_shore_m = 0.6;
    /// (c) Minimum share of the surrounding cells that must show ground: roofs and trees are not a
    /// shore.
    double ground_share_of_shore = 0.5;
    /// (c) Minimum share of its cells that must be surrounded by it: shadows of houses are thin.
    double inner_share_of_void = 0.1;
};

/// Whether a cell, by itself, may be water: open (covered, with no returns, or with more than twice
/// as many water returns as others), or wet-looking with almost only ground and water returns. All
/// other cells are dry.
[[nodiscard]] bool is_open(const WaterCell& cell) noexcept;
[[nodiscard]] bool is_wet(const WaterCell& cell) noexcept;
[[nodiscard]] bool is_candidate(const WaterCell& cell, const Evidence& evidence) noexcept;

/// A complete set of connected candidates, and access to the surrounding cells.
class Candidates {
public:
    virtual ~Candidates() = default;
    /// Sorted by z, then x.
    [[nodiscard]] virtual const std::vector<CellPlace>& places() const = 0;
    /// @return null where cells were not loaded (beyond the squares along which very large bodies
    /// are divided)
    [[nodiscard]] virtual const WaterCell* find(CellPlace place) const = 0;
};

/// One body and the candidates that it consists of.
struct FoundBody {
    Body body;
    std::vector<std::int32_t> members;  ///< index of each of the body's cells in the candidates
};

/// Classifies connected candidates. Connected open cells are water by (a) or else (c); connected
/// wet-looking cells are water by (b); parts that are water and touch or overlap form one body; a
/// gap without returns that lies mostly in water found by (b) is water as well; a part that fails
/// its test is dry, whatever it touches.
[[nodiscard]] std::vector<FoundBody> judge(const Candidates& candidates, const Evidence& evidence,
                                           double cell_m, double voxel_m);

/// The cells that adjoin (over edges) a subset of the candidates.
struct Shore {
    struct Cell {
        CellPlace place;
        float ground;  ///< voxels
    };
    std::vector<Cell> ground;     ///< cells with ground returns, by place
    std::size_t other = 0;        ///< number of shore cells without ground returns
    bool at_survey_edge = false;  ///< whether an uncovered cell is among them
    [[nodiscard]] std::vector<float> heights() const;
};

/// @param chosen for each candidate: not 0 = inside
[[nodiscard]] Shore find_shore(const Candidates& candidates, const Adjacency& adjacency,
                               const std::vector<std::int32_t>& members,
                               const std::vector<char>& chosen);

/// Whether this is the shore of standing water: enough of it is ground; the lower half of its
/// heights spreads less than `flat_shore_m` (the upper half is banks); and on each of the four
/// sides (quarters around the middle) some cell is equally low, since a hole in a hillside is high
/// on one side.
[[nodiscard]] bool is_level_shore(const Shore& shore, const Evidence& evidence, double voxel_m);

}  // namespace terravox::water
