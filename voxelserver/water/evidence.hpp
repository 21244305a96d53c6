#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/water/adjacency.hpp"
#include "voxelserver/water/body_levels.hpp"
#include "voxelserver/water/water_cells.hpp"

namespace terravox::water {

/// What counts as water. Lengths and heights in metres.
struct Evidence {
    bool by_class = true;  ///< (a) connected open cells with water returns: LiDAR is mostly
                           ///< swallowed, so the voids around them are water too
    bool by_photo =
        true;  ///< (b) cells that look wet and form a flat body: classification missed the water
    bool by_void = true;  ///< (c) voids within a flat shore

    std::uint32_t fewest_returns = 3;  ///< (a) in a body: one stray class code makes no lake
    double min_wet_m2 = 200;           ///< (b)
    double flat_wet_m = 0.4;           ///< (b) most spread of the middle 80 % of levels
    double min_void_m2 = 150;          ///< (c)
    double flat_shore_m =
        0.6;  ///< (c) most spread of the shore's low half, and between its four sides
    double ground_share_of_shore =
        0.5;  ///< (c) of the cells around, so many must show ground: roofs and trees are no shore
    double inner_share_of_void =
        0.1;  ///< (c) of its cells, so many must be surrounded by it: shadows of houses are thin
};

/// A cell that may be water, alone: open (covered, and nothing seen, or water more than twice as
/// often as anything else), or wet-looking with hardly anything but ground and water. All others
/// are plainly dry.
[[nodiscard]] bool is_open(const WaterCell& cell) noexcept;
[[nodiscard]] bool is_wet(const WaterCell& cell) noexcept;
[[nodiscard]] bool is_candidate(const WaterCell& cell, const Evidence& evidence) noexcept;

/// Connected candidates, whole, and the means to look at what lies around them.
class Candidates {
public:
    virtual ~Candidates() = default;
    /// Sorted by z, then x.
    [[nodiscard]] virtual const std::vector<CellPlace>& places() const = 0;
    /// @return null where cells were not loaded (beyond the squares that very large bodies are cut
    /// along)
    [[nodiscard]] virtual const WaterCell* find(CellPlace place) const = 0;
};

/// One body and which of the candidates it is made of.
struct FoundBody {
    Body body;
    std::vector<std::int32_t> members;  ///< index of each of the body's cells in the candidates
};

/// Judges connected candidates. Connected open cells are water by (a) or else (c); connected
/// wet-looking cells are water by (b); parts that are water and touch or overlap are one body; a
/// gap without returns that lies mostly in water found by (b) is water as well; what fails its test
/// is dry, whatever it touches.
[[nodiscard]] std::vector<FoundBody> judge(const Candidates& candidates, const Evidence& evidence,
                                           double cell_m, double voxel_m);

}  // namespace terravox::water
