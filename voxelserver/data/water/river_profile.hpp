#pragma once

#include <vector>

#include "voxelserver/data/water/river_sections.hpp"

namespace terravox::water {

/// Computes the level of each section, in metres above the samples' reference: close to the
/// measurements, falling towards the outlets and nowhere else.
///
/// 1. Levels are smoothed along the course and interpolated where there are no measurements
///    (drainage tree, robust weights), each stretch by its own slope: a steep brook keeps its
///    returns whatever it flows into.
/// 2. The direction of flow is found by flooding from the lowest section upwards; a second outlet
///    is an end that lies well below the rim to the first.
/// 3. The nearest levels that never fall upstream are computed: exact on the drainage tree, then
///    enforced across the two arms around islands.
/// 4. Stretches with almost no slope get one level, so that noise makes no step in a lake that a
///    river passes through. After that every section except the outlets has a neighbour that is no
///    higher, and so on down to an outlet.
/// @param samples one for each section, at least one with weight
/// Ref: priority-flood: Barnes, Lehman & Mulla, 2014; isotonic regression on trees: Pardalos & Xue,
/// "Algorithms for a class of isotonic regression problems", 1999; reweighting: Holland & Welsch,
/// "Robust regression using iteratively reweighted least-squares", 1977.
[[nodiscard]] std::vector<double> river_profile(const RiverSections& sections,
                                                const std::vector<SectionSample>& samples);

}  // namespace terravox::water
