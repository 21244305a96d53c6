#include "voxelserver/tools/survey/orthophoto.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "voxelserver/tools/survey/randomness.hpp"

namespace terravox::survey {
namespace {

Colour find_base(Cover cover) noexcept {
    switch (cover) {
        case Cover::kMeadow: return {112, 138, 66};
        case Cover::kMownMeadow: return {146, 164, 86};
        case Cover::kWheat: return {200, 180, 114};
        case Cover::kBarley: return {190, 180, 122};
        case Cover::kMaize: return {78, 118, 48};
        case Cover::kRape: return {184, 180, 74};
        case Cover::kPloughed: return {136, 106, 78};
        case Cover::kGarden: return {122, 148, 76};
        case Cover::kForest: return {74, 84, 46};
        case Cover::kScrub: return {108, 124, 62};
        case Cover::kRock: return {158, 152, 142};
        case Cover::kBeach: return {196, 184, 152};
        case Cover::kRoad: return {116, 116, 120};
        case Cover::kGravelRoad: return {196, 184, 158};
        case Cover::kCourtyard: return {188, 178, 158};
        case Cover::kBuilding: return {150, 148, 144};
    }
    return {255, 0, 255};
}

bool is_crop(Cover cover) noexcept {
    return cover >= Cover::kMeadow && cover <= Cover::kPloughed;
}

// -1 and 1 alternating, `width_m` wide.
double stripe(double across_m, double width_m) noexcept {
    const double half = across_m / (2.0 * width_m);
    return half - std::floor(half) < 0.5 ? 1.0 : -1.0;
}

double to_tint(std::uint32_t tint) noexcept {
    return static_cast<double>(tint & 0xFFFFU) / 32768.0 - 1.0;
}

}  // namespace

Colour ground_colour(std::uint64_t seed, Cover cover, Vec2 p) noexcept {
    const double coarse = noise_2d(seed + 51, p.x / 23.0, p.y / 23.0);
    const double fine = noise_2d(seed + 52, p.x / 2.1, p.y / 2.1);
    Colour colour = find_base(cover);
    double shade = 1.0 + 0.05 * coarse + 0.05 * fine;
    if (is_crop(cover)) {
        const Parcel parcel = parcel_at(seed, p);
        shade += 0.09 * parcel.shade;
        // Rows of maize and furrows, swathes of the mower, tramlines of the tractor.
        if (cover == Cover::kMaize || cover == Cover::kPloughed)
            shade += 0.07 * stripe(parcel.row, 1.0);
        if (cover == Cover::kMownMeadow)
            shade += 0.035 * stripe(parcel.row, 2.5);
        const double tram = parcel.row / 9.0 - std::floor(parcel.row / 9.0);
        if ((cover == Cover::kWheat || cover == Cover::kBarley) && tram < 0.08)
            shade -= 0.10;
        colour = colour.mixed({170, 156, 96}, 0.10 * (1.0 + coarse));
    }
    if (cover == Cover::kRock)
        shade += 0.10 * noise_2d(seed + 55, p.x / 16.0, p.y / 3.0) +
                 0.16 * noise_2d(seed + 53, p.x / 5.0, p.y / 5.0) + 0.08 * fine;
    if (cover == Cover::kGarden)
        colour =
            colour.mixed({158, 160, 100}, 0.25 * (1.0 + noise_2d(seed + 54, p.x / 9.0, p.y / 9.0)));
    if (cover == Cover::kRoad)
        shade = 1.0 + 0.03 * fine;
    return colour * shade;
}

Colour water_colour(std::uint64_t seed, Vec2 p, double depth_m, bool lake) noexcept {
    const Colour deep = lake ? Colour{30, 84, 104} : Colour{54, 96, 96};
    const Colour shallow = lake ? Colour{86, 150, 142} : Colour{112, 138, 118};
    const double clear = 1.0 / (1.0 + (lake ? 0.55 : 1.1) * depth_m);
    return deep.mixed(shallow, clear) * (1.0 + 0.025 * noise_2d(seed + 61, p.x / 14.0, p.y / 5.0));
}

Colour roof_colour(const Building& building, int side) noexcept {
    constexpr std::array<Colour, 4> kRoofs = {
        {{178, 84, 56}, {118, 120, 126}, {186, 182, 174}, {112, 150, 132}}};
    const double facing =
        (side == 0 ? 1.0 : -1.0) * (building.direction.x - building.direction.y) * 0.05;
    const double flat = building.roof == RoofType::kFlat ? 0.0 : facing;
    return kRoofs[static_cast<std::size_t>(building.colour)] *
           (1.0 + 0.10 * to_tint(building.tint) + flat);
}

Colour crown_colour(const Tree& tree) noexcept {
    const double tint = to_tint(tree.tint);
    if (tree.kind == TreeKind::kConifer)
        return Colour{46, 78, 44} * (1.0 + 0.16 * tint);
    const Colour leaves = tree.kind == TreeKind::kBush ? Colour{96, 122, 58} : Colour{80, 116, 46};
    const bool yellowish = ((tree.tint >> 16) & 7U) == 0;
    return leaves.mixed({138, 146, 60}, yellowish ? 0.45 : 0.0) * (1.0 + 0.15 * tint);
}

namespace {

constexpr double kLand_m = -1e5;  ///< below everything that stands on the land

/// The picture with a height for each pixel: the highest object wins.
class Canvas {
public:
    Canvas(const Box2& box, Shading shading)
        : m_box(box),
          m_side(static_cast<int>((box.x1 - box.x0) / kOrthophotoPixel_m)),
          m_shading(shading) {
        const auto pixels = static_cast<std::size_t>(m_side) * static_cast<std::size_t>(m_side);
        m_rgb.resize(pixels * 3);
        m_top.assign(pixels, -1e6F);
        if (shading == Shading::kNone)
            m_slope.resize(pixels);
    }
    /// Whether colours contain the light of a veiled sun.
    [[nodiscard]] bool is_shaded() const noexcept { return m_shading == Shading::kSoft; }
    [[nodiscard]] int side() const noexcept { return m_side; }
    [[nodiscard]] Vec2 centre(int column, int row) const noexcept {
        return {m_box.x0 + (column + 0.5) * kOrthophotoPixel_m,
                m_box.y1 - (row + 0.5) * kOrthophotoPixel_m};
    }
    /// @param slope of the surface, rise over run eastwards and northwards
    void put(int column, int row, double height_m, Colour colour, Vec2 slope = {}) {
        const auto i = static_cast<std::size_t>(row) * static_cast<std::size_t>(m_side) +
                       static_cast<std::size_t>(column);
        if (height_m < m_top[i])
            return;
        m_top[i] = static_cast<float>(height_m);
        if (!m_slope.empty())
            m_slope[i] = {static_cast<float>(slope.x), static_cast<float>(slope.y)};
        const auto part = [](double v) {
            return static_cast<std::uint8_t>(std::clamp(v + 0.5, 0.0, 255.0));
        };
        m_rgb[3 * i] = part(colour.r);
        m_rgb[3 * i + 1] = part(colour.g);
        m_rgb[3 * i + 2] = part(colour.b);
    }
    /// Calls visit(column, row, place) for each pixel with its centre in the box.
    template <class Visit>
    void over(const Box2& box, const Visit& visit) const {
        const auto to_column = [&](double x) { return (x - m_box.x0) / kOrthophotoPixel_m; };
        const auto to_row = [&](double y) { return (m_box.y1 - y) / kOrthophotoPixel_m; };
        const auto within = [&](double v) {
            return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(m_side)));
        };
        for (int row = within(to_row(box.y1)); row < within(to_row(box.y0) + 1.0); ++row)
            for (int column = within(to_column(box.x0)); column < within(to_column(box.x1) + 1.0);
                 ++column)
                visit(column, row, centre(column, row));
    }
    [[nodiscard]] Painting take() {
        return {m_side, std::move(m_rgb), std::move(m_top), std::move(m_slope)};
    }

private:
    Box2 m_box;
    int m_side;
    Shading m_shading;
    std::vector<std::uint8_t> m_rgb;
    std::vector<float> m_top;
    std::vector<Painting::Slope> m_slope;
};

/// The slope of a surface by its heights half a metre around; where it ends, of the inner half.
template <class Height>
Vec2 measure_slope(Vec2 p, const Height& height_m) {
    constexpr double kStep_m = 0.25;
    const auto along = [&](Vec2 step) {
        const std::optional<double> here = height_m(p);
        const std::optional<double> before = height_m(p - step);
        const std::optional<double> after = height_m(p + step);
        const double low = before ? *before : here.value_or(0);
        const double high = after ? *after : here.value_or(0);
        const double run = kStep_m * ((before ? 1.0 : 0.0) + (after ? 1.0 : 0.0));
        return run > 0 ? (high - low) / run : 0.0;
    };
    return {along({kStep_m, 0}), along({0, kStep_m})};
}

double soft_shade(Vec2 gradient) noexcept {
    // A high, veiled sun in the south-west.
    const double facing =
        0.5 * (gradient.x + gradient.y) / std::sqrt(1.0 + dot(gradient, gradient));
    return std::clamp(1.0 + 0.22 * facing, 0.8, 1.15);
}

Colour land_colour(const SquareModel& model, Vec2 p, bool lake_near, bool shaded) {
    if (const auto level = model.water_m(p))
        return water_colour(model.seed(), p, *level - model.ground_m(p), lake_near);
    // Land boundaries are softened by up to half a metre; road edges are exact.
    const std::uint64_t seed = model.seed();
    const Vec2 ragged{p.x + 0.5 * noise_2d(seed + 71, p.x / 1.7, p.y / 1.7),
                      p.y + 0.5 * noise_2d(seed + 72, p.x / 1.7, p.y / 1.7)};
    const double edge = model.road_edge_m(p);
    Cover cover = model.cover(ragged);
    const bool road_node = cover == Cover::kRoad || cover == Cover::kGravelRoad;
    if (road_node && edge > 0.1 && edge < 29.0)
        cover = Cover::kMeadow;
    if (!road_node && edge <= 0.1)
        cover = model.cover(p) == Cover::kGravelRoad ? Cover::kGravelRoad : Cover::kRoad;
    Colour colour = ground_colour(seed, cover, p);
    if (cover == Cover::kRoad && edge > -0.35)
        colour = colour.mixed({196, 194, 188}, 0.35);
    return shaded ? colour * soft_shade(model.gradient(p)) : colour;
}

void paint_land(const SquareModel& model, Canvas& canvas) {
    const auto& sites = model.terrain().sites();
    for (int row = 0; row < canvas.side(); ++row)
        for (int column = 0; column < canvas.side(); ++column) {
            const Vec2 p = canvas.centre(column, row);
            bool lake_near = false;
            for (const Site& site : sites)
                lake_near = lake_near || (site.lake && length(p - site.lake->centre) <
                                                           site.lake->reach_m() + 3.0);
            canvas.put(column, row, kLand_m, land_colour(model, p, lake_near, canvas.is_shaded()),
                       model.water_m(p) ? Vec2{} : model.gradient(p));
        }
}

void paint_bridges(const SquareModel& model, Canvas& canvas) {
    for (const Bridge& bridge : model.roads().bridges)
        canvas.over(bridge.bounds(), [&](int column, int row, Vec2 p) {
            const double top = bridge.top_m(p);
            if (top == kNoWater)
                return;
            const bool parapet = top > bridge.deck_m;
            canvas.put(column, row, top,
                       parapet                     ? Colour{190, 184, 172}
                       : bridge.half_width_m < 3.0 ? Colour{168, 150, 122}
                                                   : Colour{128, 127, 128});
        });
}

void paint_buildings(const SquareModel& model, Canvas& canvas) {
    for (const Building& building : model.buildings())
        canvas.over(building.bounds(), [&](int column, int row, Vec2 p) {
            const auto top = building.top_m(p);
            if (!top)
                return;
            const Vec2 from = p - building.centre;
            const double across = dot(from, turn_left(building.direction));
            const double along = dot(from, building.direction);
            Colour colour = roof_colour(building, across > 0 ? 0 : 1);
            // Rows of tiles, a lighter ridge, a rim on flat roofs.
            const double tiles = std::floor(std::abs(across) * 2.0);
            const double rim = std::min(building.half_width_m - std::abs(across),
                                        building.half_length_m - std::abs(along));
            if (building.roof == RoofType::kFlat)
                colour = colour * (rim < 0.6 ? 1.08 : 0.97);
            else if (*top > building.ridge_m - 0.3)
                colour = colour * 1.08;
            else
                colour = colour * (tiles - 2.0 * std::floor(tiles / 2.0) < 1.0 ? 1.02 : 0.98);
            canvas.put(column, row, *top, colour,
                       canvas.is_shaded() ? Vec2{} : measure_slope(p, [&](Vec2 at) {
                           return building.top_m(at);
                       }));
        });
}

void paint_trees(const SquareModel& model, Canvas& canvas) {
    for (const Tree& tree : model.trees()) {
        const Box2 box{tree.at.x - tree.radius_m, tree.at.y - tree.radius_m,
                       tree.at.x + tree.radius_m, tree.at.y + tree.radius_m};
        const Colour crown = crown_colour(tree);
        canvas.over(box, [&](int column, int row, Vec2 p) {
            const Vec2 from = p - tree.at;
            const double ragged = 1.0 + 0.22 * noise_2d(tree.tint, p.x / 0.9, p.y / 0.9);
            const auto top = tree.crown_top_m(length(from) * ragged);
            if (!top)
                return;
            const double lit =
                (from.x * -0.6 - from.y * 0.6) / tree.radius_m;  // lighter towards the south-west
            const double grain =
                static_cast<double>(compute_hash(tree.tint, column, row) & 0xFFU) / 255.0 - 0.5;
            canvas.put(column, row, *top, crown * (1.0 + 0.10 * lit + 0.16 * grain));
        });
    }
}

}  // namespace

Painting paint(const SquareModel& model, Shading shading, double margin_m) {
    Canvas canvas(model.extent().box().expanded(margin_m), shading);
    paint_land(model, canvas);
    paint_bridges(model, canvas);
    paint_buildings(model, canvas);
    paint_trees(model, canvas);
    Painting painting = canvas.take();
    for (int row = 0; row < painting.side_px; ++row)
        for (int column = 0; column < painting.side_px; ++column) {
            float& top = painting.top_m[static_cast<std::size_t>(row) *
                                            static_cast<std::size_t>(painting.side_px) +
                                        static_cast<std::size_t>(column)];
            const Vec2 p = canvas.centre(column, row);
            const double land = model.water_m(p).value_or(model.ground_m(p));
            top = std::max(top, static_cast<float>(land));
        }
    return painting;
}

SquareRaster<std::uint8_t> paint_orthophoto(const SquareModel& model) {
    Painting painting = paint(model, Shading::kSoft, 0);
    return {painting.side_px, 3, std::move(painting.rgb)};
}

}  // namespace terravox::survey
