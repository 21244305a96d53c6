#include "voxelserver/tools/survey/truth.hpp"

#include <array>
#include <nlohmann/json.hpp>

#include "common/util/version.hpp"

namespace terravox::survey {
namespace {

constexpr double kWireColumn_m = 0.5;  ///< a wire belongs to the columns within half a metre

TrueKind find_kind(Cover cover) noexcept {
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

TrueKind find_kind(RoofColour colour) noexcept {
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
        out.kind = find_kind(m_model.cover(p));
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
            show(i, static_cast<float>(*top), find_kind(b.colour));
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

const char* to_name(TrueKind kind) noexcept {
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

namespace {

// Keys in the order in which they are written: the files are also read by people.
using Json = nlohmann::ordered_json;

double cm(double v) noexcept {
    return std::floor(v * 100.0 + 0.5) / 100.0;
}

Json position(Vec2 p) {
    return Json::array({cm(p.x + kPlaceEasting_m), cm(p.y + kPlaceNorthing_m)});
}

Json ring(const std::vector<Vec2>& points) {
    Json out = Json::array();
    for (const Vec2 p : points)
        out.push_back(position(p));
    return out;
}

Json list_buildings(const SquareModel& model, const Box2& box) {
    Json out = Json::array();
    for (const Building& b : model.buildings()) {
        if (!b.bounds().overlaps(box))
            continue;
        Json building{{"use", to_name(b.use)},         {"roof", to_name(b.roof)},
                      {"colour", to_name(b.colour)},   {"ground_m", cm(b.ground_m)},
                      {"eaves_m", cm(b.eaves_m)},      {"ridge_m", cm(b.ridge_m)},
                      {"footprint", ring(b.outline())}};
        if (b.open_beneath())
            building["underside_m"] = cm(b.underside_m);
        out.push_back(std::move(building));
    }
    return out;
}

Json list_trees(const SquareModel& model, const Box2& box) {
    Json out = Json::array();
    for (const Tree& t : model.trees())
        if (box.expanded(t.radius_m).contains(t.at))
            out.push_back({{"kind", to_name(t.kind)},
                           {"at", position(t.at)},
                           {"ground_m", cm(t.ground_m)},
                           {"height_m", cm(t.height_m)},
                           {"crown_radius_m", cm(t.radius_m)}});
    return out;
}

Json line_with_levels(const Brook& brook) {
    Json line = Json::array();
    Json levels = Json::array();
    for (const auto& vertex : brook.line) {
        line.push_back(position(vertex.at));
        levels.push_back(cm(vertex.level_m));
    }
    return {{"kind", "brook"},
            {"width_m", cm(2.0 * brook.half_width_m)},
            {"line", line},
            {"level_m", levels}};
}

std::optional<Json> river_in(const River& river, const Box2& box) {
    Json line = Json::array();
    Json levels = Json::array();
    Json widths = Json::array();
    bool inside = false;
    for (double x = box.x0 - 20.0; x <= box.x1 + 20.0; x += 10.0) {
        const Vec2 p{x, river.centre_y(x)};
        inside = inside || box.expanded(20.0).contains(p);
        line.push_back(position(p));
        levels.push_back(cm(river.level_m(x)));
        widths.push_back(cm(2.0 * river.half_width_m(x)));
    }
    if (!inside)
        return std::nullopt;
    return Json{{"kind", "river"}, {"line", line}, {"level_m", levels}, {"width_m", widths}};
}

Json list_waters(const SquareModel& model, const Box2& box) {
    Json out = Json::array();
    for (const River& river : model.terrain().rivers())
        if (auto found = river_in(river, box))
            out.push_back(std::move(*found));
    for (const Site& site : model.terrain().sites()) {
        if (site.lake) {
            const double reach = site.lake->reach_m();
            const Vec2 c = site.lake->centre;
            if (Box2{c.x - reach, c.y - reach, c.x + reach, c.y + reach}.overlaps(box))
                out.push_back({{"kind", "lake"},
                               {"level_m", cm(site.lake->level_m)},
                               {"shore", ring(site.lake->shore_ring(128))}});
        }
        if (site.brook)
            for (const auto& vertex : site.brook->line)
                if (box.expanded(20.0).contains(vertex.at)) {
                    out.push_back(line_with_levels(*site.brook));
                    break;
                }
    }
    return out;
}

Json list_bridges(const SquareModel& model, const Box2& box) {
    Json out = Json::array();
    for (const Bridge& b : model.roads().bridges)
        if (b.bounds().overlaps(box))
            out.push_back({{"line", ring({b.centre - b.direction * b.half_length_m,
                                          b.centre + b.direction * b.half_length_m})},
                           {"deck_m", cm(b.deck_m)},
                           {"water_m", cm(b.water_m)},
                           {"width_m", cm(2.0 * b.half_width_m)}});
    return out;
}

Json describe_power_line(const SquareModel& model, const Box2& box) {
    Json pylons = Json::array();
    for (const Pylon& p : model.power_line().pylons)
        if (box.expanded(kPylonArm_m).contains(p.at))
            pylons.push_back(
                {{"at", position(p.at)}, {"ground_m", cm(p.ground_m)}, {"top_m", cm(p.top_m)}});
    return {{"pylons", pylons}};
}

Json list_landmarks(const SquareModel& model, const Box2& box) {
    Json out = Json::array();
    const auto add = [&](const char* name, Vec2 at, double height_m) {
        if (box.contains(at))
            out.push_back({{"name", name}, {"at", position(at)}, {"ground_m", cm(height_m)}});
    };
    for (const Site& site : model.terrain().sites()) {
        if (site.castle)
            add("castle", site.castle->centre, site.castle->top_m);
        if (site.island) {
            add("island", site.island->centre, site.island->top_m);
            add("island church", site.island->centre, site.island->top_m);
        }
        if (box.contains(site.church))
            add("parish church", site.church, model.ground_m(site.church));
    }
    return out;
}

Json describe_square(const SquareExtent& extent) {
    return {{"name", extent.name()},
            {"extent_m",
             {extent.east_m, extent.north_m, extent.east_m + extent.size_m,
              extent.north_m + extent.size_m}}};
}

}  // namespace

SquareRaster<float> true_ground(const SquareModel& model) {
    const int side = model.extent().size_m;
    const Box2 box = model.extent().box();
    SquareRaster<float> raster{side, 1, {}};
    raster.pixels.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column)
            raster.pixels.push_back(
                static_cast<float>(model.ground_m({box.x0 + column + 0.5, box.y1 - row - 0.5})));
    return raster;
}

SquareRaster<std::uint8_t> true_kinds(const SquareModel& model) {
    SquareRaster<std::uint8_t> raster{model.extent().size_m, 1, {}};
    const auto columns = true_columns(model);
    raster.pixels.reserve(columns.size());
    for (const TrueColumn& column : columns)
        raster.pixels.push_back(static_cast<std::uint8_t>(column.kind));
    return raster;
}

std::string truth_json(const SquareModel& model) {
    const Box2 box = model.extent().box();
    Json out = describe_square(model.extent());
    out["version"] = kTruthVersion;
    out["crs"] = kSurveyCrs;
    out["landmarks"] = list_landmarks(model, box);
    out["waters"] = list_waters(model, box);
    out["bridges"] = list_bridges(model, box);
    out["power_line"] = describe_power_line(model, box);
    out["buildings"] = list_buildings(model, box);
    out["trees"] = list_trees(model, box);
    return out.dump() + "\n";
}

std::string place_json(const SurveyOptions& options) {
    Json out{{"version", kTruthVersion},
             {"generator", std::string("terravox survey ") + kVersion},
             {"crs", kSurveyCrs}};
    out["seed"] = options.seed;
    out["density_per_m2"] = options.density;
    out["square_m"] = options.square_m;
    out["squares"] = {{"east", options.squares_east}, {"north", options.squares_north}};
    out["extent_m"] = {
        options.origin_east_m, options.origin_north_m,
        options.origin_east_m + std::int64_t{options.square_m} * options.squares_east,
        options.origin_north_m + std::int64_t{options.square_m} * options.squares_north};
    out["orthophoto_pixel_m"] = 0.5;
    if (options.photo_light)
        out["photo_light"] = {{"azimuth_deg", options.photo_light->azimuth_deg},
                              {"altitude_deg", options.photo_light->altitude_deg},
                              {"haze", options.photo_light->haze},
                              {"clouds", options.photo_light->clouds}};
    Json names = Json::array();
    for (const SquareExtent& extent : list_squares(options))
        names.push_back(describe_square(extent));
    out["files"] = names;
    return out.dump(2) + "\n";
}

}  // namespace terravox::survey
