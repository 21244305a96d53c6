#include "voxelserver/tools/survey/true_columns.hpp"

#include <array>

namespace terravox::survey {
namespace {

constexpr double kWireColumn_m = 0.5;  ///< a wire belongs to the columns within half a metre

TrueKind kind_of(Cover cover) noexcept {
    switch (cover) {
        case Cover::kPloughed:
        case Cover::kRock:
        case Cover::kBeach:
        case Cover::kCourtyard: return TrueKind::kBare;
        case Cover::kRoad: return TrueKind::kRoad;
        case Cover::kGravelRoad: return TrueKind::kGravelRoad;
        default: return TrueKind::kGrass;
    }
}

TrueKind kind_of(RoofColour colour) noexcept {
    constexpr std::array kKinds = {TrueKind::kRoofRed, TrueKind::kRoofGrey, TrueKind::kRoofPale,
                                   TrueKind::kRoofCopper};
    return kKinds[static_cast<std::size_t>(colour)];
}

/// The columns of a square with the height of what each shows: the highest object wins.
class Columns {
public:
    explicit Columns(const SquareModel& model)
        : m_model(model), m_box(model.extent().box()), m_side(model.extent().size_m) {
        const auto count = static_cast<std::size_t>(m_side) * static_cast<std::size_t>(m_side);
        m_columns.resize(count);
        m_top.resize(count);
        for (int row = 0; row < m_side; ++row)
            for (int column = 0; column < m_side; ++column)
                lay_ground(column, row);
    }

    void build() {
        for (std::size_t i = 0; i < m_model.buildings().size(); ++i)
            add_building(static_cast<std::uint32_t>(i));
        for (const Bridge& bridge : m_model.roads().bridges)
            over(bridge.bounds(), [&](std::size_t i, Vec2 p) {
                const auto top = static_cast<float>(bridge.top_m(p));
                if (top <= static_cast<float>(kNoWater))
                    return;
                m_columns[i].deck_m = std::max(m_columns[i].deck_m, top);
                show(i, top, TrueKind::kBridge);
            });
        for (const Tree& tree : m_model.trees())
            over(around(tree.at, tree.radius_m), [&](std::size_t i, Vec2 p) {
                const auto top = tree.crown_top_m(length(p - tree.at));
                if (!top)
                    return;
                m_columns[i].crown_m = std::max(m_columns[i].crown_m, static_cast<float>(*top));
                show(i, static_cast<float>(*top), TrueKind::kTree);
            });
        add_power_line();
    }
    [[nodiscard]] std::vector<TrueColumn> take() { return std::move(m_columns); }

private:
    [[nodiscard]] std::size_t index(int column, int row) const noexcept {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(m_side) +
               static_cast<std::size_t>(column);
    }
    [[nodiscard]] Vec2 centre(int column, int row) const noexcept {
        return {m_box.x0 + column + 0.5, m_box.y1 - row - 0.5};
    }
    [[nodiscard]] static Box2 around(Vec2 p, double r) noexcept {
        return {p.x - r, p.y - r, p.x + r, p.y + r};
    }

    /// Calls visit(index, centre) for each column with its centre in a box.
    template <class Visit>
    void over(const Box2& box, const Visit& visit) const {
        const auto within = [&](double v) {
            return static_cast<int>(std::clamp(std::floor(v), 0.0, static_cast<double>(m_side)));
        };
        for (int row = within(m_box.y1 - box.y1); row < within(m_box.y1 - box.y0 + 1.0); ++row)
            for (int column = within(box.x0 - m_box.x0); column < within(box.x1 - m_box.x0 + 1.0);
                 ++column)
                visit(index(column, row), centre(column, row));
    }

    void show(std::size_t i, float top_m, TrueKind kind) noexcept {
        if (top_m <= m_top[i])
            return;
        m_top[i] = top_m;
        m_columns[i].kind = kind;
    }

    void lay_ground(int column, int row) {
        const Vec2 p = centre(column, row);
        const std::size_t i = index(column, row);
        TrueColumn& out = m_columns[i];
        out.ground_m = static_cast<float>(m_model.ground_m(p));
        out.kind = kind_of(m_model.cover(p));
        m_top[i] = out.ground_m;
        if (const auto water = m_model.water_m(p)) {
            out.water_m = static_cast<float>(*water);
            show(i, std::max(out.water_m, out.ground_m + 1e-3F), TrueKind::kWater);
        }
    }

    void add_building(std::uint32_t number) {
        const Building& b = m_model.buildings()[number];
        over(b.bounds(), [&](std::size_t i, Vec2 p) {
            const auto top = b.top_m(p);
            if (!top)
                return;
            TrueColumn& out = m_columns[i];
            const bool first = out.building == TrueColumn::kNone;
            out.open_building = b.open_beneath() && (first || out.open_building);
            if (b.open_beneath() && (first || static_cast<float>(b.underside_m) < out.underside_m))
                out.underside_m = static_cast<float>(b.underside_m);
            if (first || static_cast<float>(*top) > out.roof_m) {
                out.roof_m = static_cast<float>(*top);
                out.building = number;
            }
            show(i, static_cast<float>(*top), kind_of(b.colour));
        });
    }

    void add_power_line() {
        for (const Pylon& pylon : m_model.power_line().pylons)
            over(around(pylon.at, kPylonArm_m), [&](std::size_t i, Vec2 p) {
                // From the top down: the first height at which mast or arm holds the point.
                for (double height = pylon.top_m; height > pylon.ground_m; height -= 0.5)
                    if (pylon.holds(p, height))
                        return show(i, static_cast<float>(height), TrueKind::kPylon);
            });
        for (const Wire& wire : m_model.power_line().wires) {
            const Box2 box{std::min(wire.a.x, wire.b.x), std::min(wire.a.y, wire.b.y),
                           std::max(wire.a.x, wire.b.x), std::max(wire.a.y, wire.b.y)};
            over(box.expanded(1.0), [&](std::size_t i, Vec2 p) {
                const OnSegment on = nearest_on_segment(p, wire.a, wire.b);
                if (on.distance_m <= kWireColumn_m)
                    show(i, static_cast<float>(wire.height_m(on.along)), TrueKind::kWire);
            });
        }
    }

    const SquareModel& m_model;
    Box2 m_box;
    int m_side;
    std::vector<TrueColumn> m_columns;
    std::vector<float> m_top;
};

}  // namespace

const char* name_of(TrueKind kind) noexcept {
    constexpr std::array kNames = {
        "",         "grass",     "bare",      "road",        "gravel road", "water", "tree",
        "red roof", "grey roof", "pale roof", "copper roof", "bridge",      "wire",  "pylon"};
    return kNames[static_cast<std::size_t>(kind)];
}

std::vector<TrueColumn> true_columns(const SquareModel& model) {
    Columns columns(model);
    columns.build();
    return columns.take();
}

}  // namespace terravox::survey
