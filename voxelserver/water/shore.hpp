#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/water/evidence.hpp"

namespace terravox::water {

/// The ring of cells (over edges) around some of the candidates.
struct Shore {
    struct Cell {
        CellPlace place;
        float ground;  ///< voxels
    };
    std::vector<Cell> ground;     ///< cells with ground returns, by place
    std::size_t other = 0;        ///< cells without
    bool at_survey_edge = false;  ///< an uncovered cell is among them
    [[nodiscard]] std::vector<float> heights() const;
};

/// @param chosen for each candidate: not 0 = inside
[[nodiscard]] Shore shore_of(const Candidates& candidates, const Adjacency& beside,
                             const std::vector<std::int32_t>& members,
                             const std::vector<char>& chosen);

/// Is it the shore of standing water? Enough of it is ground; its low half spreads less than
/// `flat_shore_m` (its high half is banks); and on each of the four sides (quarters around the
/// middle) something lies equally low, for a hole in a hillside is high on one side.
[[nodiscard]] bool is_level_shore(const Shore& shore, const Evidence& evidence, double voxel_m);

}  // namespace terravox::water
