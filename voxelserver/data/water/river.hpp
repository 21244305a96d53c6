#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/data/water/body_levels.hpp"
#include "voxelserver/data/water/water_cells.hpp"

namespace terravox::water {

struct WeightedLevel {
    float level;
    std::uint32_t weight;
    bool operator<(const WeightedLevel& o) const noexcept {
        return level != o.level ? level < o.level : weight < o.weight;
    }
};

/// A water body divided into cross-sections, and their adjacency: a graph whose cycles go around
/// islands and whose branches are tributaries.
struct RiverSections {
    double length_m = 0;                   ///< length of one section along the course
    std::vector<std::int32_t> section_of;  ///< section of each cell
    /// For each section: the distance from the end at which the division began.
    std::vector<double> along_m;
    std::vector<std::uint32_t> cells;  ///< number of cells of each section
    /// Index in `neighbours` of each section's first neighbour; size() + 1 elements.
    std::vector<std::uint32_t> begin;
    std::vector<std::int32_t> neighbours;  ///< neighbours of all sections, ascending for each
    [[nodiscard]] std::int32_t size() const noexcept {
        return static_cast<std::int32_t>(cells.size());
    }
    template <class Visit>
    void each_neighbour(std::int32_t s, const Visit& visit) const {
        for (std::uint32_t i = begin[static_cast<std::size_t>(s)];
             i < begin[static_cast<std::size_t>(s) + 1]; ++i)
            visit(neighbours[i]);
    }
};

/// Divides the distance through the water from one end (nearly Euclidean, within 2 %) into rings of
/// two cells; the connected parts of a ring are sections. Parts that end after three sections
/// (notches of the bank) are merged into the section that they branch from.
/// @param adjacency one connected body, not empty
/// Ref: the graph of a function's level sets: Reeb, 1946; chamfer distances 5-7-11: Borgefors,
/// "Distance transformations in digital images", 1986; buckets in place of a heap: Dial, "Algorithm
/// 360", 1969.
[[nodiscard]] RiverSections make_sections(const Adjacency& adjacency, double cell_m);

/// The measurements in one section.
struct SectionSample {
    double level_m = 0;  ///< weighted median, metres above the reference
    double weight = 0;   ///< number of returns; 0: no measurement
};

/// @param reference zero of the sections' levels, in voxels
[[nodiscard]] std::vector<SectionSample> section_samples(const RiverSections& sections,
                                                         const std::vector<LevelSample>& samples,
                                                         float reference, double voxel_m);

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
