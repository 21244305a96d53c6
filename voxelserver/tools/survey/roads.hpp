#pragma once

#include <vector>

#include "voxelserver/tools/survey/plane.hpp"
#include "voxelserver/tools/survey/terrain.hpp"

namespace terravox::survey {

/// A road with heights. Neighbouring vertices are about kRoadStep_m apart.
struct Road {
    struct Vertex {
        Vec2 at;
        double height_m = 0;
        bool on_bridge = false;  ///< the segment from here to the next vertex is on a bridge
        bool houses = false;     ///< houses or farms line the road here: gardens around it
    };
    std::vector<Vertex> line;
    double half_width_m = 2.5;
    RoadSurface surface = RoadSurface::kAsphalt;
};
inline constexpr double kRoadStep_m = 4.0;

/// A straight deck over water.
struct Bridge {
    Vec2 centre;
    Vec2 direction;  ///< of length 1
    double half_length_m = 0;
    double half_width_m = 0;
    double deck_m = 0;   ///< height of the road surface in the middle; constant
    double water_m = 0;  ///< level of the water below
    /// @return height of the deck or parapet at p, or kNoWater outside the bridge
    [[nodiscard]] double top_m(Vec2 p) const noexcept;
    [[nodiscard]] Box2 bounds() const noexcept;
};
inline constexpr double kParapet_m = 1.1;         ///< above the deck
inline constexpr double kRiverClearance_m = 5.2;  ///< deck above river
inline constexpr double kBrookClearance_m = 2.4;  ///< deck above brook

/// All roads and bridges that may reach into an area. Streets of sites, valley roads along rivers,
/// paths around lakes.
struct RoadNet {
    std::vector<Road> roads;
    std::vector<Bridge> bridges;
};
/// @param terrain made for `area` or a larger one
/// @return roads in a fixed order; a function of seed and place only
[[nodiscard]] RoadNet build_roads(const Terrain& terrain, const Box2& area);

/// The streets of one site alone, with the heights and bridges that build_roads gives them.
[[nodiscard]] RoadNet build_streets(const Terrain& terrain, const Site& site);

}  // namespace terravox::survey
