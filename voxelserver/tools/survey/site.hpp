#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "voxelserver/tools/survey/plane.hpp"
#include "voxelserver/tools/survey/waters.hpp"

namespace terravox::survey {

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

/// An island of the lake: a mound with a flat top.
struct Island {
    Vec2 centre;
    double radius_x_m = 0;
    double radius_y_m = 0;
    double top_m = 0;
};

/// A rock with a flat top, steep on the south side.
struct CastleRock {
    Vec2 centre;
    double radius_x_m = 0;
    double radius_y_m = 0;
    double top_m = 0;
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
    std::optional<Island> island;
    std::optional<CastleRock> castle;
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

}  // namespace terravox::survey
