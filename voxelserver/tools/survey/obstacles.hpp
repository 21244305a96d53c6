#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "voxelserver/tools/survey/square_model.hpp"

namespace terravox::survey {

enum class ObstacleKind : std::uint8_t { kBuilding, kBridge, kTree, kPylon, kWire };

struct Obstacle {
    ObstacleKind kind;
    std::uint32_t index;  ///< in the model's list of that kind
};

/// Finds the obstacles that a pulse may hit above the ground: a grid of cells of 8 m; each lists
/// what a pulse whose foot is in the cell can touch at the greatest lean. Immutable, thread-safe;
/// holds no reference to the model.
class ObstacleGrid {
public:
    explicit ObstacleGrid(const SquareModel& model);
    /// @param foot in the square or kObstacleMargin_m around it
    [[nodiscard]] std::span<const Obstacle> at(Vec2 foot) const noexcept {
        const auto cell = static_cast<std::size_t>((foot.y - m_area.y0) * kPerCell) * m_columns +
                          static_cast<std::size_t>((foot.x - m_area.x0) * kPerCell);
        return {m_items.data() + m_starts[cell], m_starts[cell + 1] - m_starts[cell]};
    }

private:
    static constexpr double kCell_m = 8;
    static constexpr double kPerCell = 1.0 / kCell_m;
    template <class Visit>
    void for_each_cell(const Box2& box, const Visit& visit) const;
    template <class Visit>
    void for_each_obstacle(const SquareModel& model, const Visit& visit) const;

    Box2 m_area;
    std::size_t m_columns;
    std::size_t m_rows;
    std::vector<std::uint32_t> m_starts;
    std::vector<Obstacle> m_items;
};

inline constexpr double kObstacleMargin_m = 32;

}  // namespace terravox::survey
