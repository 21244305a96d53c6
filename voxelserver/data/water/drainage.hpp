#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/data/water/river_sections.hpp"

namespace terravox::water {

/// A drainage tree: the parent of each section is the section that it drains to.
struct Drainage {
    std::vector<std::int32_t> order;   ///< parents before children
    std::vector<std::int32_t> parent;  ///< of each section; Adjacency::kNone for an outlet
    std::vector<std::int32_t> rank;    ///< position of each section in `order`
};

/// Paths with the fewest sections to section `root`: for use before levels are known.
[[nodiscard]] Drainage breadth_first(const RiverSections& sections, std::int32_t root);

/// Paths along which `levels` rise the least, starting from the outlet: the lowest dead end when it
/// is within 0.1 m of the lowest section, else that section. A dead end that lies more than `rim_m`
/// below the lowest way out of it is an outlet of its own (a river that divides, water that leaves
/// the survey twice).
[[nodiscard]] Drainage drain(const RiverSections& sections, const std::vector<double>& levels,
                             double rim_m);

/// The nearest levels (weighted least squares) such that none is lower than its parent's: exact.
[[nodiscard]] std::vector<double> isotonic(const Drainage& drainage,
                                           const std::vector<double>& levels,
                                           const std::vector<double>& weights);

/// The mean of the highest level downstream and the lowest level upstream, over all neighbours and
/// not only the tree: never falls upstream.
[[nodiscard]] std::vector<double> between_envelopes(const RiverSections& sections,
                                                    const Drainage& drainage,
                                                    const std::vector<double>& levels);

/// Raises sections that are lower than a neighbour further downstream.
void raise_to_lower(const RiverSections& sections, const Drainage& drainage,
                    std::vector<double>& levels);

}  // namespace terravox::water
