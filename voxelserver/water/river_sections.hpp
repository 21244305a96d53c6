#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/water/adjacency.hpp"
#include "voxelserver/water/body_levels.hpp"

namespace terravox::water {

struct WeightedLevel {
    float level;
    std::uint32_t weight;
    bool operator<(const WeightedLevel& o) const noexcept {
        return level != o.level ? level < o.level : weight < o.weight;
    }
};

/// A body cut into cross-sections, and which of them touch: a graph whose cycles go around islands
/// and whose branches are tributaries.
struct RiverSections {
    double length_m = 0;                   ///< of one section along the course
    std::vector<std::int32_t> section_of;  ///< of each cell
    std::vector<double>
        along_m;  ///< of each section: the way from the end at which the cutting began
    std::vector<std::uint32_t> cells;  ///< of each section
    std::vector<std::uint32_t>
        begin;  ///< of each section's neighbours in `beside`; size() + 1 of them
    std::vector<std::int32_t> beside;  ///< ascending
    [[nodiscard]] std::int32_t size() const noexcept {
        return static_cast<std::int32_t>(cells.size());
    }
    template <class Visit>
    void neighbours(std::int32_t s, const Visit& visit) const {
        for (std::uint32_t i = begin[static_cast<std::size_t>(s)];
             i < begin[static_cast<std::size_t>(s) + 1]; ++i)
            visit(beside[i]);
    }
};

/// Distances through the water from one end (nearly Euclidean, within 2 %), cut into rings of two
/// cells; the connected parts of a ring are sections. Parts that end after three sections (notches
/// of the bank) are given to the section they hang on.
/// @param beside one connected body, not empty
/// Ref: the graph of a function's level sets: Reeb, 1946; chamfer distances 5-7-11: Borgefors,
/// "Distance transformations in digital images", 1986; buckets in place of a heap: Dial, "Algorithm
/// 360", 1969.
[[nodiscard]] RiverSections make_sections(const Adjacency& beside, double cell_m);

/// What was seen of one section.
struct SectionSample {
    double level_m = 0;  ///< weighted median, metres above the reference
    double weight = 0;   ///< returns; 0: nothing was seen
};

/// @param reference voxels
[[nodiscard]] std::vector<SectionSample> section_samples(const RiverSections& sections,
                                                         const std::vector<LevelSample>& samples,
                                                         float reference, double voxel_m);

}  // namespace terravox::water
