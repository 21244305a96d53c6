#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxelserver/tools/survey/plane.hpp"
#include "voxelserver/tools/survey/site.hpp"
#include "voxelserver/tools/survey/waters.hpp"

namespace terravox::survey {

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
