#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/data/water/evidence.hpp"

namespace terravox::water {

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
[[nodiscard]] Shore shore_of(const Candidates& candidates, const Adjacency& adjacency,
                             const std::vector<std::int32_t>& members,
                             const std::vector<char>& chosen);

/// Whether this is the shore of standing water: enough of it is ground; the lower half of its
/// heights spreads less than `flat_shore_m` (the upper half is banks); and on each of the four
/// sides (quarters around the middle) some cell is equally low, since a hole in a hillside is high
/// on one side.
[[nodiscard]] bool is_level_shore(const Shore& shore, const Evidence& evidence, double voxel_m);

}  // namespace terravox::water
