#pragma once

#include <vector>

#include "voxelserver/water/river_sections.hpp"

namespace terravox::water {

/// The level of each section, metres above the samples' reference: close to what was seen, falling
/// towards the outlets and nowhere else.
///
/// 1. Levels are smoothed along the course and bridged where nothing was seen (drainage tree,
/// robust weights), each stretch by its own fall: a
///    steep brook keeps its returns whatever it runs into.
/// 2. The way the water runs: flooding from the lowest section upwards; a second outlet is an end
/// that lies well below the rim to the first.
/// 3. The nearest levels that never fall upstream: exact on the tree of ways, then made to hold
/// across islands' two arms.
/// 4. Stretches nearly without slope take one level, so that noise makes no step in a lake that a
/// river passes through. After that every section but the outlets has a neighbour that is no
/// higher, and so on down to an outlet.
/// @param samples one for each section, at least one with weight
/// Ref: priority-flood: Barnes, Lehman & Mulla, 2014; isotonic regression on trees: Pardalos & Xue,
/// "Algorithms for a class of isotonic regression problems", 1999; reweighting: Holland & Welsch,
/// "Robust regression using iteratively reweighted least-squares", 1977.
[[nodiscard]] std::vector<double> river_profile(const RiverSections& sections,
                                                const std::vector<SectionSample>& samples);

}  // namespace terravox::water
