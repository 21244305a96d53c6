#include "voxelserver/make/voxelize/steps/runs.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "common/voxel/box_builder.hpp"
#include "voxelserver/make/voxelize/steps/house_returns.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"

namespace terravox::voxelize {

namespace {

using voxel::Material;
using voxel::VoxelAttr;

std::int32_t floor_y(float height) {
    return static_cast<std::int32_t>(std::floor(height));
}
std::int32_t rounded(double metres, double voxel_m) {
    // No world is as high; a greater value would overflow where it is added to a height.
    constexpr double kMax = 1'000'000;
    return static_cast<std::int32_t>(std::lround(std::min(metres / voxel_m, kMax)));
}
std::int32_t in_voxels(double metres, double voxel_m) {
    return std::max(1, rounded(metres, voxel_m));
}

template <class Seen>
VoxelAttr to_attr(Material material, const Seen& s) {
    VoxelAttr attr;
    attr.material = material;
    attr.source_class = s.source_class;
    if (s.has_colour) {
        attr.colour = s.colour;
        attr.flags = VoxelAttr::kHasColour;
    }
    return attr;
}

}  // namespace

class RunsBuilder {
public:
    explicit RunsBuilder(const RunsInput& input)
        : m_in(input),
          m_houses(input.window, input.classes, input.ground, input.settings.vegetation,
                   input.voxel_m) {}

    PatchRuns build() {
        PatchRuns out;
        constexpr int kSide = PatchRuns::kSide;
        out.m_begin.assign(kSide * kSide + 1, 0);
        constexpr std::size_t kUsual = 3;  // ground, and two more of a plant or a house
        out.m_runs.reserve(kUsual * kSide * kSide);
        bool any = false;
        std::size_t i = 0;
        for (int z = -1; z <= grid::kPatchSize; ++z)
            for (int x = -1; x <= grid::kPatchSize; ++x, ++i) {
                m_runs.clear();
                if (m_in.covered.at(x, z) != 0)
                    column(x, z);
                out.m_runs.insert(out.m_runs.end(), m_runs.begin(), m_runs.end());
                out.m_begin[i + 1] = static_cast<std::uint32_t>(out.m_runs.size());
                const bool inner = x >= 0 && z >= 0 && x < grid::kPatchSize && z < grid::kPatchSize;
                if (!inner || m_runs.empty())
                    continue;
                out.m_min_y = any ? std::min(out.m_min_y, m_runs.front().y0) : m_runs.front().y0;
                out.m_max_y = any ? std::max(out.m_max_y, m_runs.back().y1) : m_runs.back().y1;
                any = true;
            }
        return out;
    }

private:
    static constexpr std::int32_t kNothing = INT32_MIN / 2;

    void column(int x, int z) {
        const Column& col = m_in.window.column(x, z);
        const Roof& roof = m_in.roofs.at(x, z);
        std::int32_t top = m_in.water.is_water(x, z) ? water(col, x, z) : dry_land(col, roof, x, z);
        if (roof.seen())
            building(roof, top, x, z);
        if (const Surface& deck = m_in.decks.at(x, z); deck.seen()) {
            const std::int32_t y = floor_y(deck.height);
            const std::int32_t thickness =
                in_voxels(m_in.settings.bridges.thickness_m, m_in.voxel_m);
            push(std::max(y + 1 - thickness, top + 1), y + 1,
                 to_attr(named(deck) ? meaning(deck.source_class).material : Material::kBridge,
                         deck));
            top = std::max(top, y);  // heights on a deck count from the deck
        }
        objects(x, z, top, roof.seen());
    }

    /// @return voxel of the surface
    std::int32_t water(const Column& col, int x, int z) {
        const std::int32_t surface = floor_y(m_in.water.level.at(x, z));
        const std::int32_t depth = in_voxels(m_in.water.depth_m.at(x, z), m_in.voxel_m);
        const std::int32_t bed = std::max(surface - depth, std::min(m_in.floor_y, surface - 1));
        terrain(bed, VoxelAttr{Material::kSand, 0, 0, 0, {}, 0}, 0);
        push(bed + 1, surface + 1, to_attr(Material::kWater, col.water));
        return surface;
    }

    /// @return voxel of the surface, or kNothing where no ground is known
    std::int32_t dry_land(const Column& col, const Roof& roof, int x, int z) {
        const float ground = m_in.ground.at(x, z);
        if (ground != ground)
            return kNothing;
        const std::int32_t top = floor_y(ground);
        const bool hidden = m_in.decks.at(x, z).seen() &&
                            !named(m_in.decks.at(x, z));  // the ground that was seen is the deck
        VoxelAttr attr{Material::kGround, 0, 0, 0, {}, 0};
        if (col.ground.seen() && !hidden)
            attr = to_attr(meaning(col.ground.source_class).material, col.ground);
        if (!hidden && (!roof.seen() || roof.open_beneath()))
            specialize(attr, x, z);
        terrain(top, attr, soil(x, z));
        return top;
    }

    // Whether a deck is one by its class.
    [[nodiscard]] bool named(const Surface& deck) const {
        return meaning(deck.source_class).role == Role::kBridge;
    }

    void specialize(VoxelAttr& attr, int x, int z) const {
        const Material m = m_in.special.at(x, z);
        if (m == Material::kAir)
            return;
        attr.material = m;
        if (m_in.guessed.at(x, z) != 0)
            attr.flags |= VoxelAttr::kGuessed;
    }

    // Gives a voxel of unknown colour that of its building or tree.
    void tint(VoxelAttr& attr, const HouseNumber* house) const {
        if (house != nullptr && !attr.has_colour())
            set_typical(attr, m_in.numbers.tints->of(attr.material, *house));
    }
    void tint_plant(VoxelAttr& attr, int x, int z) const {
        const std::uint64_t number = m_in.numbers.tree.at(x, z);
        if (number != PlaceNumbers::kNone && !attr.has_colour())
            set_typical(attr, m_in.numbers.tints->of(attr.material, number));
    }
    static void set_typical(VoxelAttr& attr, const std::optional<voxel::Rgb8>& colour) {
        if (!colour)
            return;
        attr.colour = *colour;
        attr.flags |= VoxelAttr::kTinted;
    }

    [[nodiscard]] const ClassMeaning& meaning(std::uint8_t source_class) const {
        return m_in.classes.meaning[source_class];
    }

    void terrain(std::int32_t top, const VoxelAttr& attr, std::int16_t soil_voxels) {
        push(std::min(m_in.floor_y, top), top + 1, attr);
        m_runs.back().terrain = true;
        m_runs.back().soil = soil_voxels;
    }

    [[nodiscard]] std::int16_t soil(int x, int z) const {
        const float here = m_in.ground.at(x, z);
        float drop = 0;
        for (const float there : {m_in.ground.at(x - 1, z), m_in.ground.at(x + 1, z),
                                  m_in.ground.at(x, z - 1), m_in.ground.at(x, z + 1)})
            if (there == there)
                drop = std::max(drop, here - there);
        if (drop * m_in.voxel_m > m_in.settings.ground.cliff_m)
            return 0;
        constexpr std::int32_t kMax = INT16_MAX;  // 100 m of soil exceed it in voxels of 3 mm
        return static_cast<std::int16_t>(
            std::min(in_voxels(m_in.settings.ground.soil_m, m_in.voxel_m), kMax));
    }

    void building(const Roof& roof, std::int32_t ground_top, int x, int z) {
        const std::int32_t roof_y = floor_y(roof.top.height);
        VoxelAttr attr = to_attr(meaning(roof.top.source_class).material, roof.top);
        specialize(attr, x + roof.appearance_dx, z + roof.appearance_dz);
        const HouseNumber* const house = m_in.numbers.house(x, z);
        tint(attr, house);
        if (roof_y <= ground_top) {  // a roof no higher than the ground: a garage, a terrace
            if (m_runs.back().terrain)
                m_runs.back().attr = attr;
            return;
        }
        VoxelAttr wall = attr;
        wall.material = Material::kWall;
        wall.flags = 0;
        wall.colour = {};  // seen from above, a point's colour is the roof's, not the wall's
        tint(wall, house);
        const std::int32_t skin = roof_bottom(roof_y, x, z);
        std::int32_t foot = ground_top + 1;
        if (roof.open_beneath())
            foot = std::max(foot, floor_y(roof.bottom));
        else if (ground_top == kNothing)
            foot = skin;
        push(foot, skin, wall);
        push(std::max(skin, foot), roof_y + 1, attr);
    }

    // A steep roof shows its flank: it is roof down to the next column's roof. A greater drop is a
    // wall between two parts.
    [[nodiscard]] std::int32_t roof_bottom(std::int32_t roof_y, int x, int z) const {
        const std::int32_t steepest = rounded(m_in.settings.buildings.steep_roof_m, m_in.voxel_m);
        std::int32_t bottom = roof_y;
        for (const Roof* next : {&m_in.roofs.at(x - 1, z), &m_in.roofs.at(x + 1, z),
                                 &m_in.roofs.at(x, z - 1), &m_in.roofs.at(x, z + 1)}) {
            if (!next->seen())
                continue;
            const std::int32_t y = floor_y(next->top.height);
            if (roof_y - y <= steepest)
                bottom = std::min(bottom, y + 1);
        }
        return bottom;
    }

    void objects(int x, int z, std::int32_t top, bool roofed) {
        const Crown& crown = m_in.crowns.at(x, z);
        bool crown_done = !crown.seen();
        m_trunk.reset();
        if (crown.seen() && crown.trunk && !roofed && !m_runs.empty() && m_runs.back().terrain)
            m_trunk = crown.top_voxel.source_class;
        for (const ObjectVoxel& o : m_in.window.objects(x, z)) {
            if (!crown_done &&
                o.y >= crown.bottom) {  // all foliage from here to the top is one crown
                put_crown(crown, x, z, top, roofed);
                crown_done = true;
            }
            object(o, x, z, top, roofed);
        }
        if (!crown_done)
            put_crown(crown, x, z, top, roofed);
    }

    void put_crown(const Crown& crown, int x, int z, std::int32_t top, bool roofed) {
        if (m_runs.empty())
            return;
        VoxelAttr attr = to_attr(plant(crown.top_voxel, height_m(crown.top, top)), crown.top_voxel);
        tint_plant(attr, x, z);
        std::int32_t bottom = std::max(crown.bottom, crown_floor(top));
        const Run& below = m_runs.back();
        if ((roofed || voxel::is_plant(below.attr.material)) && below.y1 + canopy_gap() >= bottom)
            bottom = below.y1;  // lower returns of the same crown, or a roof on which it stands
        push_plant(bottom, crown.top + 1, attr);
        m_trunk.reset();  // it ends in the crown
    }

    // Where a tree stands, its trunk fills the space below and between its foliage.
    void push_plant(std::int32_t y0, std::int32_t y1, const VoxelAttr& attr) {
        if (m_trunk && m_runs.back().y1 < y0) {
            VoxelAttr trunk;
            trunk.material = Material::kTrunk;
            trunk.source_class = *m_trunk;
            push(m_runs.back().y1, y0, trunk);
        }
        push(y0, y1, attr);
    }

    [[nodiscard]] std::int32_t canopy_gap() const {
        return rounded(m_in.settings.vegetation.canopy_gap_m, m_in.voxel_m);
    }

    // A crown that a neighbour extends downwards does not become a bush.
    [[nodiscard]] std::int32_t crown_floor(std::int32_t top) const {
        return top == kNothing ? kNothing
                               : top + in_voxels(m_in.settings.vegetation.low_m, m_in.voxel_m) + 1;
    }

    void object(const ObjectVoxel& o, int x, int z, std::int32_t top, bool roofed) {
        const ClassMeaning& m = meaning(o.source_class);
        if (!m_runs.empty() && o.y < m_runs.back().y1) {
            // In or below what is there already. Plants on the ground colour it green.
            if (m.role == Role::kVegetation && o.y == top && !roofed && m_runs.back().terrain &&
                m_runs.back().attr.material == Material::kGround)
                m_runs.back().attr.material = Material::kGrass;
            return;
        }
        const double above_m = height_m(o.y, top);
        if (m.role == Role::kSurface && above_m < m_in.settings.vegetation.clutter_m)
            return;
        if (m_in.settings.points.drop_isolated && above_m > kNearGround_m &&
            isolated(m_in.window, x, z, o.y))
            return;
        if (const auto part = m_houses.part(x, z, o); part != HouseReturns::Part::kNone) {
            // A chimney or a parapet is as its roof. A roof no higher than the ground is terrain.
            if (part == HouseReturns::Part::kOnRoof && roofed && !m_runs.empty() &&
                !m_runs.back().terrain)
                m_runs.back().y1 = o.y + 1;
            return;
        }
        const bool plant_like = m.role == Role::kVegetation || m.role == Role::kSurface;
        const bool on_crown = plant_like && !m_runs.empty() && !m_runs.back().terrain &&
                              m_runs.back().y1 < o.y && m_runs.back().y1 + canopy_gap() >= o.y &&
                              m_runs.back().attr.source_class == o.source_class &&
                              m_runs.back().attr.material != Material::kTrunk;
        const std::int32_t from = on_crown ? m_runs.back().y1 : o.y;
        VoxelAttr attr = to_attr(m.tiers ? tier(above_m) : m.material, o);
        if (plant_like)
            tint_plant(attr, x, z);
        if (plant_like)
            push_plant(from, o.y + 1, attr);
        else
            push(from, o.y + 1, attr);
    }

    [[nodiscard]] double height_m(std::int32_t y, std::int32_t top) const noexcept {
        return top == kNothing ? 0 : (y - top) * m_in.voxel_m;
    }
    [[nodiscard]] Material plant(const ObjectVoxel& o, double above_m) const {
        return meaning(o.source_class).tiers ? tier(above_m) : meaning(o.source_class).material;
    }
    [[nodiscard]] Material tier(double above_m) const {
        return above_m < m_in.settings.vegetation.low_m      ? Material::kLowVegetation
               : above_m < m_in.settings.vegetation.medium_m ? Material::kMediumVegetation
                                                             : Material::kHighVegetation;
    }

    void push(std::int32_t y0, std::int32_t y1, const VoxelAttr& attr) {
        if (!m_runs.empty())
            y0 = std::max(y0, m_runs.back().y1);
        if (y0 >= y1)
            return;
        Run& run = m_runs.emplace_back();
        run.y0 = y0;
        run.y1 = y1;
        run.attr = attr;
    }

    // Higher objects must be connected to something: birds and stray returns are not.
    static constexpr double kNearGround_m = 2.5;

    const RunsInput& m_in;
    HouseReturns m_houses;
    std::vector<Run> m_runs;
    // The trunk's class, while a column of a tree is filled from below.
    std::optional<std::uint8_t> m_trunk;
};

PatchRuns make_runs(const RunsInput& input) {
    return RunsBuilder(input).build();
}

namespace {

// Whether an image shows a run: the topmost surface and the foliage of crowns; not walls, beds or
// trunks, nor the ground under a bridge.
bool shows(const Run& run, bool topmost) noexcept {
    const Material m = run.attr.material;
    if (m == Material::kWall || m == Material::kWater || m == Material::kWire ||
        m == Material::kTrunk)
        return false;
    return topmost || voxel::is_plant(m);
}

VoxelAttr attr_at(std::span<const Run> runs, std::int32_t y, const voxel::Rgb8* seen_from_above) {
    // From above: most voxels that are seen are those on top.
    auto run = runs.end();
    while (run != runs.begin() && y < std::prev(run)->y1)
        --run;
    if (run == runs.end() || y < run->y0)
        return {};
    VoxelAttr out;
    if (run->terrain && y != run->y1 - 1) {
        out.material = run->y1 - 1 - y <= run->soil ? Material::kSoil : Material::kRock;
        out.source_class = run->attr.source_class;
        return out;
    }
    out = run->attr;
    if (seen_from_above != nullptr && shows(*run, run + 1 == runs.end())) {
        out.colour = *seen_from_above;
        out.flags =
            static_cast<std::uint8_t>((out.flags & ~VoxelAttr::kTinted) | VoxelAttr::kHasColour);
    }
    return out;
}

}  // namespace

std::shared_ptr<const voxel::Box> serialize(const voxel::BoxKey& key, const PatchRuns& runs,
                                            const SurfaceAppearance& appearance) {
    const std::int32_t base = key.by * voxel::kBoxSizeY;
    if (runs.max_y() <= base || runs.min_y() >= base + voxel::kBoxSizeY)
        return nullptr;
    voxel::BoxBuilder builder;
    for (int z = -1; z <= grid::kPatchSize; ++z)
        for (int x = -1; x <= grid::kPatchSize; ++x)
            for (const Run& run : runs.column(x, z)) {
                if (run.y1 < base || run.y0 > base + voxel::kBoxSizeY)
                    continue;
                builder.add(x, z, std::max(run.y0 - base, -1),
                            std::min(run.y1 - base, voxel::kBoxSizeY + 1),
                            !voxel::see_through(run.attr.material));
            }
    return builder.build(key, [&](int x, int y, int z) {
        return attr_at(runs.column(x, z), base + y, appearance.colour(x, z));
    });
}

}  // namespace terravox::voxelize
