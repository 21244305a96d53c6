#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/data/water/adjacency.hpp"
#include "voxelserver/data/water/body_levels.hpp"

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

}  // namespace terravox::water
