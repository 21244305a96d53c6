#include "voxelserver/tools/survey/obstacles.hpp"

#include "voxelserver/tools/survey/scan_pattern.hpp"

namespace terravox::survey {

template <class Visit>
void ObstacleGrid::for_each_cell(const Box2& box, const Visit& visit) const {
    const auto clamped = [](double v, std::size_t count) {
        return static_cast<std::size_t>(std::clamp(v, 0.0, static_cast<double>(count - 1)));
    };
    if (!box.overlaps(m_area))
        return;
    const auto c0 = clamped((box.x0 - m_area.x0) * kPerCell, m_columns);
    const auto c1 = clamped((box.x1 - m_area.x0) * kPerCell, m_columns);
    const auto r0 = clamped((box.y0 - m_area.y0) * kPerCell, m_rows);
    const auto r1 = clamped((box.y1 - m_area.y0) * kPerCell, m_rows);
    for (auto row = r0; row <= r1; ++row)
        for (auto column = c0; column <= c1; ++column)
            visit(row * m_columns + column);
}

// Calls visit(obstacle, box of feet): the outline, widened by how far a pulse leans between the
// ground and the top. The ground under a pulse's foot may lie lower than at the obstacle, so 8 m
// are added to each height.
template <class Visit>
void ObstacleGrid::for_each_obstacle(const SquareModel& model, const Visit& visit) const {
    const auto widened = [](const Box2& box, double height_m) {
        return box.expanded((height_m + 8.0) * ScanPattern::kMaxLean);
    };
    const auto around = [](Vec2 p, double r) { return Box2{p.x - r, p.y - r, p.x + r, p.y + r}; };
    std::uint32_t i = 0;
    for (const Building& b : model.buildings())
        visit({ObstacleKind::kBuilding, i++}, widened(b.bounds(), b.top_of_all_m() - b.ground_m));
    i = 0;
    for (const Bridge& b : model.roads().bridges)
        visit({ObstacleKind::kBridge, i++}, widened(b.bounds(), b.deck_m - b.water_m));
    i = 0;
    for (const Tree& t : model.trees())
        visit({ObstacleKind::kTree, i++}, widened(around(t.at, t.radius_m), t.height_m - 6.0));
    i = 0;
    for (const Pylon& p : model.power_line().pylons)
        visit({ObstacleKind::kPylon, i++}, widened(around(p.at, kPylonArm_m), kPylonHeight_m));
    i = 0;
    for (const Wire& w : model.power_line().wires) {
        // In pieces: the box around a whole span would be far too wide.
        for (int piece = 0; piece < 16; ++piece) {
            const Vec2 a = w.a + (w.b - w.a) * (piece / 16.0);
            const Vec2 b = w.a + (w.b - w.a) * ((piece + 1) / 16.0);
            visit({ObstacleKind::kWire, i}, widened({std::min(a.x, b.x), std::min(a.y, b.y),
                                                     std::max(a.x, b.x), std::max(a.y, b.y)},
                                                    kPylonHeight_m));
        }
        ++i;
    }
}

ObstacleGrid::ObstacleGrid(const SquareModel& model)
    : m_area(model.extent().box().expanded(kObstacleMargin_m)) {
    m_columns = static_cast<std::size_t>((m_area.x1 - m_area.x0) * kPerCell) + 1;
    m_rows = static_cast<std::size_t>((m_area.y1 - m_area.y0) * kPerCell) + 1;
    // Two passes: count, then place. A wire found twice in one cell is listed once.
    m_starts.assign(m_columns * m_rows + 1, 0);
    std::vector<std::uint32_t> last_wire(m_columns * m_rows, ~0U);
    const auto repeated = [&](Obstacle o, std::size_t cell) {
        if (o.kind != ObstacleKind::kWire)
            return false;
        const bool same = last_wire[cell] == o.index;
        last_wire[cell] = o.index;
        return same;
    };
    for_each_obstacle(model, [&](Obstacle o, const Box2& box) {
        for_each_cell(box, [&](std::size_t cell) {
            if (!repeated(o, cell))
                ++m_starts[cell + 1];
        });
    });
    for (std::size_t i = 1; i < m_starts.size(); ++i)
        m_starts[i] += m_starts[i - 1];
    m_items.resize(m_starts.back());
    auto next = m_starts;
    last_wire.assign(last_wire.size(), ~0U);
    for_each_obstacle(model, [&](Obstacle o, const Box2& box) {
        for_each_cell(box, [&](std::size_t cell) {
            if (!repeated(o, cell))
                m_items[next[cell]++] = o;
        });
    });
}

}  // namespace terravox::survey
