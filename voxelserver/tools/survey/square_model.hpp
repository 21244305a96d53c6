#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/tools/survey/building.hpp"
#include "voxelserver/tools/survey/land_cover.hpp"
#include "voxelserver/tools/survey/power_line.hpp"
#include "voxelserver/tools/survey/roads.hpp"
#include "voxelserver/tools/survey/terrain.hpp"

namespace terravox::survey {

/// The place of a square: whole metres, EPSG:3794; [east, east + size) by [north, north + size).
struct SquareExtent {
    std::int64_t east_m = 0;
    std::int64_t north_m = 0;
    int size_m = 1000;
    [[nodiscard]] Box2 box() const noexcept;  ///< in the place frame
    /// TM_462_101 for 1 km squares on whole kilometres, else TM_462240_101232.
    [[nodiscard]] std::string name() const;
};

/// Everything in one square and in a margin around it. A function of seed and extent; where two
/// squares (or their margins) overlap, their models agree to the bit. Immutable after construction,
/// thread-safe. Memory: about 18 bytes for each square metre, whatever the size of the survey.
class SquareModel {
public:
    /// @param threads to build with, at least 1
    SquareModel(std::uint64_t seed, const SquareExtent& extent, int threads);

    [[nodiscard]] const SquareExtent& extent() const noexcept { return m_extent; }
    [[nodiscard]] std::uint64_t seed() const noexcept { return m_seed; }
    [[nodiscard]] const Terrain& terrain() const noexcept { return m_terrain; }

    // All of these may be called for points within the square and kModelMargin_m - 1 around it.
    /// Bare ground with roads; bilinear between nodes 1 m apart.
    [[nodiscard]] double ground_m(Vec2 p) const noexcept;
    /// Gradient of the ground, rise over run eastwards and northwards.
    [[nodiscard]] Vec2 gradient(Vec2 p) const noexcept;
    /// Level of the water where it is wet.
    [[nodiscard]] std::optional<double> water_m(Vec2 p) const noexcept;
    [[nodiscard]] Cover cover(Vec2 p) const noexcept;  ///< of the nearest node
    /// Metres to the edge of the nearest road, negative on it; at most 30.
    [[nodiscard]] double road_edge_m(Vec2 p) const noexcept;

    [[nodiscard]] const std::vector<Building>& buildings() const noexcept { return m_buildings; }
    [[nodiscard]] const std::vector<Tree>& trees() const noexcept { return m_trees; }
    [[nodiscard]] const RoadNet& roads() const noexcept { return m_roads; }
    [[nodiscard]] const PowerLine& power_line() const noexcept { return m_power_line; }

private:
    struct Node {
        std::size_t index;
        double fx;
        double fy;
    };
    [[nodiscard]] std::size_t index(int column, int row) const noexcept;
    [[nodiscard]] std::size_t nearest(Vec2 p) const noexcept;
    [[nodiscard]] Node node_below(Vec2 p) const noexcept;
    [[nodiscard]] Vec2 place(int column, int row) const noexcept;
    [[nodiscard]] double bilinear(const std::vector<float>& field, Vec2 p) const noexcept;
    template <class Visit>
    void near_nodes(Vec2 p, double reach_m, const Visit& visit) const;

    void shape_ground(int threads);
    void build_road_bed();
    void gather_buildings();
    void mark_obstacles();
    void measure_streets(std::vector<float>& to_street) const;
    void lay_cover(int threads);
    [[nodiscard]] Cover cover_at(int column, int row, double to_street_m) const;
    [[nodiscard]] std::optional<Cover> built_cover(Vec2 p, std::size_t i) const;
    [[nodiscard]] TreeGround tree_ground(Vec2 p) const;

    std::uint64_t m_seed;
    SquareExtent m_extent;
    Box2 m_area;  ///< square and margin
    int m_side;   ///< nodes along one side
    Terrain m_terrain;
    RoadNet m_roads;
    PowerLine m_power_line;
    std::vector<Building> m_buildings;
    std::vector<Tree> m_trees;
    std::vector<float> m_ground;
    std::vector<float> m_water;
    std::vector<float> m_road_edge;
    std::vector<float> m_clear;
    std::vector<std::uint8_t> m_gravel;  ///< 1 where the nearest road is of gravel
    std::vector<Cover> m_cover;
};

inline constexpr int kModelMargin_m = 64;

}  // namespace terravox::survey
