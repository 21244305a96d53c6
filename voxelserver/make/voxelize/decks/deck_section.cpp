#include "voxelserver/make/voxelize/decks/deck_section.hpp"

#include <algorithm>
#include <cmath>

#include "common/voxel/world.hpp"

namespace terravox::voxelize {

LandSample DeckLand::evaluate(int x, int z) {
    const Column& c = m_window.column(x, z);
    if (c.built_upon())
        return {c.roof.height, LandKind::kBuilt};
    if (c.bridged())
        return {c.deck.height, LandKind::kDeck};
    if (c.water.seen() && c.water_points >= c.ground_points)
        return {c.water.height, LandKind::kWater};
    if (c.ground.seen())
        return {c.ground.height, LandKind::kGround};
    if (const auto objects = m_window.objects(x, z); !objects.empty()) {
        const ObjectVoxel& lowest = objects.front();
        const ClassMeaning& m = m_classes.meaning[lowest.source_class];
        const bool thin =
            m.material == voxel::Material::kWire || m.material == voxel::Material::kTower;
        const bool solid = m.role == Role::kSurface || (m.role == Role::kObject && !thin);
        if (!solid)
            return {kNoHeight, LandKind::kUnknown};
        return {static_cast<float>(lowest.y) + static_cast<float>(lowest.fraction) / 256,
                LandKind::kThing};
    }
    const float level = body_level(x, z);
    return {level, level == level ? LandKind::kWater : LandKind::kUnknown};
}

float DeckLand::body_level(int x, int z) {
    if (m_water == nullptr)
        return kNoHeight;
    const std::int32_t cell = m_water->cell_voxels;
    const std::int32_t cx = voxel::floor_div(m_window.middle.x0() + x, cell);
    const std::int32_t cz = voxel::floor_div(m_window.middle.z0() + z, cell);
    if (cx != m_cell_x || cz != m_cell_z) {
        m_cell_x = cx;
        m_cell_z = cz;
        m_cell_level = m_water->level_near(cx, cz);
    }
    return m_cell_level;
}

namespace {

// Columns of width by which a straight cut is preferred to one turned by 22.5 degrees.
constexpr int kAskew = 4;
constexpr float kAbrupt = 0.7F;  // share of the whole drop that lies at the edge

int columns(double metres, double voxel_m, int min, int max) {
    return std::clamp(static_cast<int>(std::lround(metres / voxel_m)), min, max);
}

}  // namespace

DeckLimits::DeckLimits(const Settings::Bridges& settings, double voxel_m)
    : drop(static_cast<float>(settings.min_drop_m / voxel_m)),
      above_water(static_cast<float>(settings.above_water_m / voxel_m)),
      above_land(static_cast<float>(settings.above_land_m / voxel_m)),
      level(static_cast<float>(0.5 / voxel_m)),
      slope(0.06F),
      step(static_cast<float>(0.25 / voxel_m)),
      parapet(static_cast<float>(1.6 / voxel_m)),
      same(static_cast<float>(1.0 / voxel_m)),
      widest(columns(settings.widest_m, voxel_m, 1, DeckReach::kWidest)),
      gap(columns(3, voxel_m, 2, 3)) {}

int DeckSections::rounded(float d, int steps) noexcept {
    const float at = d * static_cast<float>(steps);
    return static_cast<int>(at < 0 ? at - 0.5F : at + 0.5F);
}

const DeckSection* DeckSections::at(int x, int z) {
    std::int32_t& index = m_index.at(x, z);
    if (index == kNotSearched) {
        index = kNone;
        if (const auto found = cut(x, z)) {
            index = static_cast<std::int32_t>(m_sections.size());
            m_sections.push_back(*found);
        }
    }
    return index == kNone ? nullptr : &m_sections[static_cast<std::size_t>(index)];
}

std::optional<DeckSection> DeckSections::cut(int x, int z) {
    const LandSample& own = m_land.at(x, z);
    if (own.kind != LandKind::kGround && own.kind != LandKind::kThing)
        return std::nullopt;
    std::optional<DeckSection> best;
    int best_cost = 0;
    for (std::size_t d = 0; d < kDeckDirections.size(); ++d) {
        const auto [dx, dz] = kDeckDirections[d];
        const Transect ahead{x, z, dx, dz, own.height, own.kind == LandKind::kThing};
        const Transect back{x, z, -dx, -dz, own.height, ahead.things};
        const auto a = side(back);
        if (!a)
            continue;
        const auto b = opposite(ahead, static_cast<int>(d));
        DeckSection out;
        out.height = own.height;
        out.direction = static_cast<std::int8_t>(d);
        out.of_things = ahead.things;
        if (!b || !joins(*a, *b, out))
            continue;
        const int cost = out.width() + kAskew * b->askew;
        if (!best || cost < best_cost) {
            best = out;
            best_cost = cost;
        }
    }
    return best;
}

// A river bends, and a bank need not be parallel to the deck: where nothing is low straight across,
// the direction may be slightly oblique.
std::optional<DeckSections::Side> DeckSections::opposite(Transect transect, int direction) {
    constexpr int kCount = static_cast<int>(kDeckDirections.size());
    for (const int turn : {0, 1, -1, 2, -2}) {
        const int turned = direction + turn;
        const auto& [dx, dz] =
            kDeckDirections[static_cast<std::size_t>((turned + kCount) % kCount)];
        const float sign = turned < 0 || turned >= kCount ? -1.0F : 1.0F;  // past half a turn
        transect.dx = sign * dx;
        transect.dz = sign * dz;
        if (auto found = side(transect)) {
            found->askew = std::abs(turn);
            return found;
        }
    }
    return std::nullopt;
}

bool DeckSections::joins(const Side& a, const Side& b, DeckSection& out) const {
    out.before = static_cast<std::int8_t>(a.edge);
    out.behind = static_cast<std::int8_t>(b.edge);
    if (out.width() > m_limits.widest || std::abs(a.level - b.level) > m_limits.same)
        return false;
    const auto to_a = static_cast<float>(a.edge + 1);
    const auto to_b = static_cast<float>(b.edge + 1);
    out.below = (a.level * to_b + b.level * to_a) / (to_a + to_b);
    out.near_water = (a.water || a.near_water) && (b.water || b.near_water);
    out.over_water = out.near_water && (a.edge <= b.edge ? a.water : b.water);
    if (out.of_things && !out.near_water)
        return false;  // hedges
    const float least = out.over_water   ? m_limits.above_water
                        : out.near_water ? m_limits.drop
                                         : m_limits.above_land;
    return out.height - std::max(a.level, b.level) >= least;
}

// The last column of the deck in one direction, if the land is lower beyond it.
std::optional<DeckSections::Edge> DeckSections::edge(const Transect& transect) {
    int last = 0;
    int unknown = 0;
    int raised = 0;
    float before = transect.height;
    for (int k = 1; k < m_limits.widest + m_limits.gap; ++k) {
        const LandSample& s = sample(transect, k);
        const float tolerance = m_limits.level + m_limits.slope * static_cast<float>(k);
        if (s.kind == LandKind::kBuilt)
            return std::nullopt;
        if (s.kind == LandKind::kUnknown || (s.kind == LandKind::kThing && !transect.things)) {
            if (++unknown > m_limits.gap)
                return std::nullopt;
        } else if (s.kind == LandKind::kWater ||
                   s.height < std::max(transect.height - tolerance, before - m_limits.step)) {
            return Edge{last, std::min(before, transect.height)};
        } else {
            const bool higher = s.height > transect.height + tolerance;
            if (higher &&
                (s.height > transect.height + m_limits.parapet || ++raised > m_limits.edge))
                return std::nullopt;
            if (!higher) {
                raised = 0;
                before = s.height;
            }
            last = k;
            unknown = 0;
        }
    }
    return std::nullopt;
}

std::optional<DeckSections::Side> DeckSections::side(const Transect& transect) {
    const auto at_edge = edge(transect);
    if (!at_edge)
        return std::nullopt;
    const int last = at_edge->last;
    std::array<float, 16> lows{};
    int count = 0;
    int wet = 0;
    float first = kNoHeight;
    for (int k = last + m_limits.edge;
         k < last + m_limits.edge + m_limits.low && k <= DeckReach::kAcross; ++k) {
        const LandSample& s = sample(transect, k);
        if (s.kind == LandKind::kBuilt)
            break;
        if (s.kind == LandKind::kUnknown || s.kind == LandKind::kThing)
            continue;
        if (s.height > transect.height - m_limits.drop) {
            if (count >= 3)
                break;
            return std::nullopt;
        }
        // Plants may hide what is low, but not for long where it is land: a slope could hide there
        // as well.
        if (count == 0 && s.kind != LandKind::kWater && k > last + m_limits.edge + 1)
            return std::nullopt;
        if (count == 0)
            first = s.height;
        lows[static_cast<std::size_t>(count++)] = s.height;
        wet += s.kind == LandKind::kWater ? 1 : 0;
    }
    if (count < (wet > 0 ? 2 : 3))
        return std::nullopt;
    const auto middle = lows.begin() + count / 2;
    std::nth_element(lows.begin(), middle, lows.begin() + count);
    Side out{last, *middle, 2 * wet >= count, false, 0};
    if (at_edge->height - first < kAbrupt * (transect.height - out.level))
        return std::nullopt;
    out.near_water = out.water || water_farther(transect, last + m_limits.edge);
    return out;
}

// Over low land, a bank for one, up to the water.
bool DeckSections::water_farther(const Transect& transect, int from) {
    for (int k = from; k <= DeckReach::kAcross; ++k) {
        const LandSample& s = sample(transect, k);
        if (s.kind == LandKind::kWater)
            return true;
        if (s.kind == LandKind::kBuilt ||
            (s.kind == LandKind::kGround && s.height > transect.height - m_limits.drop))
            return false;
    }
    return false;
}

}  // namespace terravox::voxelize
