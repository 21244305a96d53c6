#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "voxelserver/tools/survey/plane.hpp"

namespace terravox::survey {

/// A lake with an irregular shore around an ellipse. Flat: one level.
struct Lake {
    Vec2 centre;
    double radius_x_m = 0;
    double radius_y_m = 0;
    double level_m = 0;
    double depth_m = 12;
    std::uint64_t seed = 0;

    /// Metres from the shore along the ray from the centre; negative in the lake.
    [[nodiscard]] double shore_distance(Vec2 p) const noexcept;
    /// @param direction of length 1
    /// @return the shore point in that direction from the centre
    [[nodiscard]] Vec2 shore_point(Vec2 direction) const noexcept;
    [[nodiscard]] double reach_m() const noexcept;  ///< no shore point is farther from the centre
    /// @return a closed ring of shore points, anticlockwise, the first one not repeated
    [[nodiscard]] std::vector<Vec2> shore_ring(int points) const;
};

/// The properties of a river at one easting.
struct RiverAtX {
    double centre_y = 0;
    /// Factor from |y - centre_y| to the approximate distance to the centre line.
    double stretch = 1;
    double level_m = 0;  ///< of the water; falls eastwards without a step
    double half_width_m = 0;
};

/// One of the parallel rivers of the endless landscape, flowing east. River 0 passes the place.
class River {
public:
    River(std::uint64_t seed, std::int64_t index) noexcept;
    [[nodiscard]] std::int64_t index() const noexcept { return m_index; }
    [[nodiscard]] double centre_y(double x) const noexcept;
    [[nodiscard]] double level_m(double x) const noexcept;
    [[nodiscard]] double half_width_m(double x) const noexcept;
    [[nodiscard]] RiverAtX at(double x) const noexcept;

private:
    std::uint64_t m_seed;
    std::int64_t m_index;
    double m_base_y;
    double m_base_level_m;
};

/// Between the centre lines of neighbouring rivers, on average.
inline constexpr double kRiverSpacing_m = 6000;
/// River 0 passes this far south of the place's centre.
inline constexpr double kRiverSouth_m = 215;
/// No centre line is farther from its average than this.
inline constexpr double kRiverSway_m = 380;

/// A brook as a polyline with a water level at each vertex, falling.
struct Brook {
    struct Vertex {
        Vec2 at;
        double level_m = 0;
    };
    std::vector<Vertex> line;
    double half_width_m = 2.5;

    struct Spot {
        double distance_m = 1e9;  ///< from the centre line
        double level_m = 0;
    };
    [[nodiscard]] Spot nearest(Vec2 p) const noexcept;
};

enum class RoadSurface : std::uint8_t { kAsphalt, kGravel };

/// The plan of a street: its course, before it has heights.
struct Street {
    std::vector<Vec2> controls;  ///< the street is a smooth curve near these
    double half_width_m = 2.5;
    RoadSurface surface = RoadSurface::kAsphalt;
    double house_step_m = 0;  ///< average distance between neighbouring houses; 0 = no houses
    double houses_from = 0, houses_to = 1;  ///< part of the length that has houses
};

/// Streets with a longer step than this are lined by farms, not by houses.
inline constexpr double kFarmStep_m = 50;

/// A mound with a flat top: the island of a lake, or the rock of a castle, steep on its south side.
struct Mound {
    Vec2 centre;
    double radius_x_m = 0;
    double radius_y_m = 0;
    double top_m = 0;
    /// 0 in the middle, 1 at its rim.
    [[nodiscard]] double outwards(Vec2 p) const noexcept {
        return length({(p.x - centre.x) / radius_x_m, (p.y - centre.y) / radius_y_m});
    }
};

/// A hill placed manually.
struct Hill {
    Vec2 centre;
    double radius_m = 0;
    double height_m = 0;
};

/// A settlement and its surroundings. Sites lie about every 1.6 km along every river; site (0, 0)
/// is the place: a lake with an island and a church, a castle on a cliff, a village and a bridge.
struct Site {
    std::int64_t along = 0, river = 0;  ///< its number along the river, and that of the river
    std::uint64_t seed = 0;
    Vec2 centre;  ///< of the village
    std::optional<Lake> lake;
    std::optional<Mound> island;
    std::optional<Mound> castle;
    std::optional<Brook> brook;
    std::vector<Hill> hills;
    std::vector<Street> streets;  ///< the first is the main street; it crosses the river
    Vec2 church;
    Vec2 church_direction;  ///< of length 1, along the nave
    [[nodiscard]] bool is_the_place() const noexcept { return along == 0 && river == 0; }
};

inline constexpr double kSiteSpacing_m = 1600;
/// Nothing of a site is farther from its centre than this (square distance).
inline constexpr double kSiteReach_m = 900;
inline constexpr double kLakeLevel_m = 475;  ///< of the lake of the place, as at Bled

/// @return the sites that may reach into `area`, in a fixed order. A function of seed and place
/// only.
[[nodiscard]] std::vector<Site> sites_near(std::uint64_t seed, const Box2& area);

/// How far north of a river its valley road runs, far from sites.
[[nodiscard]] double valley_road_offset_m(double x, std::int64_t river) noexcept;

/// The land at one point, before roads are built.
struct TerrainSpot {
    double ground_m = 0;  ///< bare ground; the bed where there is water
    /// Level of the water body here or within 2 m, kNoWater elsewhere; it is wet where ground <
    /// water.
    double water_m = 0;
    bool near_lake = false;
};
inline constexpr double kNoWater = -1e6;

/// The shape of the land: valleys with rivers, hills, and what the sites add (lakes, islands,
/// castle rock). A function of seed and place only: two terrains made for different areas agree
/// wherever both are valid. Immutable, thread-safe.
class Terrain {
public:
    /// @param area the terrain is valid inside of it and up to kTerrainReach_m outside
    Terrain(std::uint64_t seed, const Box2& area);

    /// Shared values of all points of one easting; computing it once for a column saves half of the
    /// work.
    struct Column {
        double x = 0;
        int count = 0;
        std::array<RiverAtX, 6> rivers;
    };
    [[nodiscard]] Column column(double x) const noexcept;
    [[nodiscard]] TerrainSpot at(const Column& column, double y) const noexcept;
    [[nodiscard]] TerrainSpot at(Vec2 p) const noexcept { return at(column(p.x), p.y); }

    [[nodiscard]] const std::vector<Site>& sites() const noexcept { return m_sites; }
    [[nodiscard]] const std::vector<River>& rivers() const noexcept { return m_rivers; }
    /// Steepness as rise over run, over 4 m.
    [[nodiscard]] double slope(Vec2 p) const noexcept;

private:
    struct Valley {
        double floor_m = 0;
        double distance_m = 0;
        const RiverAtX* nearest = nullptr;
    };
    [[nodiscard]] Valley valley(const Column& column, double y) const noexcept;
    [[nodiscard]] double hills(Vec2 p, const Valley& valley) const noexcept;
    void carve_lake(const Lake& lake, Vec2 p, TerrainSpot& spot) const noexcept;
    void carve_brook(const Brook& brook, Vec2 p, TerrainSpot& spot) const noexcept;

    std::uint64_t m_seed;
    std::vector<River> m_rivers;
    std::vector<Site> m_sites;
};

inline constexpr double kTerrainReach_m = 2200;

}  // namespace terravox::survey
