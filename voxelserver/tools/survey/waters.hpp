#pragma once

#include <cstdint>
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

}  // namespace terravox::survey
