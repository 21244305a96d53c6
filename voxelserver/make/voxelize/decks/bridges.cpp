#include "voxelserver/make/voxelize/decks/bridges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "voxelserver/make/voxelize/decks/deck_section.hpp"

namespace terravox::voxelize {
namespace {

static_assert(DeckSeeds::kMargin + DeckReach::kAlong <= DeckSections::kReach - 1,
              "sections along a deck must lie in their grid");

// Columns of land at the deck's height, in succession, that a deck ends on.
constexpr int kLanding = 5;
constexpr int kHidden = 6;  // columns along a deck without information: plants, cars, gaps
// Columns of a deck of unclassified returns where nothing is low next to it: banks reach up to it.
constexpr int kUncut = 14;
constexpr int kMaxSteps = 3 * DeckReach::kAlong;
constexpr int kDropped = 2;  // columns along a deck that lie low: it has ended in the air
// How fast the direction of a deck may turn, share of the new one per column.
constexpr float kBend = 0.3F;
constexpr int kDecksAround = 5;  // of eight: a gap

enum class End { kLand, kDead, kBeyond };

/// Follows a deck from one column to one of its ends. Positions are counted from that column, so
/// that every patch rounds alike.
class DeckWalk {
public:
    DeckWalk(DeckSections& sections, DeckLand& land, const DeckLimits& limits, int x, int z,
             const DeckSection& from, bool forwards)
        : m_sections(sections),
          m_land(land),
          m_limits(limits),
          m_x(x),
          m_z(z),
          m_height(from.height) {
        const auto [nx, nz] = kDeckDirections[static_cast<std::size_t>(from.direction)];
        m_along = {forwards ? -nz : nz, forwards ? nx : -nx};
        centre(from);
    }

    [[nodiscard]] End end() {
        for (int steps = 0; steps < kMaxSteps; ++steps) {
            m_at[0] += m_along[0];
            m_at[1] += m_along[1];
            const int dx = nearest(m_at[0]);
            const int dz = nearest(m_at[1]);
            if (std::max(std::abs(dx), std::abs(dz)) > DeckReach::kAlong)
                return End::kBeyond;
            if (const auto found = step(m_x + dx, m_z + dz, dx, dz))
                return *found;
        }
        return End::kDead;  // round in circles
    }
    /// There is water beneath.
    [[nodiscard]] bool over_water() const noexcept { return m_over_water; }

private:
    static int nearest(float v) noexcept { return static_cast<int>(v < 0 ? v - 0.5F : v + 0.5F); }

    std::optional<End> step(int x, int z, int dx, int dz) {
        const LandSample& s = m_land.at(x, z);
        if (s.kind == LandKind::kDeck)
            return End::kDead;  // its class defines where this bridge begins
        const bool solid = s.kind == LandKind::kGround || s.kind == LandKind::kThing;
        const bool level = solid && std::abs(s.height - m_height) <= m_limits.level;
        if (level) {
            if (const DeckSection* section = m_sections.at(x, z)) {
                m_at = {static_cast<float>(dx), static_cast<float>(dz)};
                turn(*section);
                centre(*section);
                m_height = section->height;
                m_landing = m_hidden = m_dropped = m_uncut = 0;
                m_over_water = m_over_water || section->over_water;
                return std::nullopt;
            }
        }
        if (level && s.kind == LandKind::kGround) {
            m_height = s.height;
            m_hidden = m_dropped = 0;
            if (++m_landing >= kLanding)
                return End::kLand;
            return std::nullopt;
        }
        const bool low = s.kind == LandKind::kWater ||
                         (s.kind == LandKind::kGround && s.height <= m_height - m_limits.drop);
        if (low && ++m_dropped >= kDropped)
            return End::kDead;
        if (level ? ++m_uncut > kUncut : !low && ++m_hidden > kHidden)
            return End::kDead;
        return std::nullopt;
    }

    void turn(const DeckSection& section) noexcept {
        const auto [nx, nz] = kDeckDirections[static_cast<std::size_t>(section.direction)];
        const float sign = -nz * m_along[0] + nx * m_along[1] < 0 ? -1.0F : 1.0F;
        const float ax = m_along[0] + kBend * (sign * -nz - m_along[0]);
        const float az = m_along[1] + kBend * (sign * nx - m_along[1]);
        const float length = std::sqrt(ax * ax + az * az);
        if (length > 0.1F)
            m_along = {ax / length, az / length};
    }

    void centre(const DeckSection& section) noexcept {
        const auto [nx, nz] = kDeckDirections[static_cast<std::size_t>(section.direction)];
        const float off = static_cast<float>(section.behind - section.before) * 0.5F;
        // Only across the direction ahead: an oblique cut must not move it backwards.
        const float across = nx * -m_along[1] + nz * m_along[0];
        m_at[0] += off * across * -m_along[1];
        m_at[1] += off * across * m_along[0];
    }

    DeckSections& m_sections;
    DeckLand& m_land;
    const DeckLimits& m_limits;
    int m_x;
    int m_z;
    float m_height;
    std::array<float, 2> m_at{};
    std::array<float, 2> m_along{};
    int m_landing = 0;
    int m_hidden = 0;
    int m_dropped = 0;
    int m_uncut = 0;
    bool m_over_water = false;
};

class DeckFinder {
public:
    DeckFinder(const Window& window, const ClassTable& classes, WaterAccess* water,
               const DeckLimits& limits)
        : m_window(window),
          m_limits(limits),
          m_land(window, classes, water),
          m_sections(m_land, limits) {}

    [[nodiscard]] std::unique_ptr<const FoundDecks> find(const DeckSeeds& seeds) {
        bool any = false;
        DeckSeeds::each([&](int x, int z) {
            if (seeds.at(x, z) == 0 || m_window.column(x, z).deck.seen())
                return;
            const DeckSection* found = m_sections.at(x, z);
            if (found == nullptr)
                return;
            const DeckSection section = *found;  // the walk finds more, and those move
            if (leads_from_land_to_land(x, z, section)) {
                put(x, z, section);
                any = true;
            }
        });
        if (!any)
            return nullptr;
        grow();
        return result();
    }

private:
    using Work = Grid<FoundDeck, DeckSeeds::kMargin>;

    [[nodiscard]] bool leads_from_land_to_land(int x, int z, const DeckSection& section) {
        DeckWalk ahead(m_sections, m_land, m_limits, x, z, section, true),
            back(m_sections, m_land, m_limits, x, z, section, false);
        const End a = ahead.end();
        if (a == End::kDead)
            return false;
        const End b = back.end();
        if (b == End::kDead)
            return false;
        return section.over_water || ahead.over_water() || back.over_water() || a == End::kLand ||
               b == End::kLand;
    }

    void put(int x, int z, const DeckSection& section) {
        FoundDeck& out = m_work.at(x, z);
        out.deck = surface(x, z, section.height);
        out.below = section.below;
        out.over_water = section.over_water;
        out.of_things = section.of_things;
    }

    [[nodiscard]] Surface surface(int x, int z, float height) const {
        if (const Surface& ground = m_window.column(x, z).ground; ground.seen())
            return ground;
        Surface out;
        out.height = height;
        if (const auto objects = m_window.objects(x, z); !objects.empty()) {
            out.source_class = objects.front().source_class;
            out.has_colour = objects.front().has_colour;
            out.colour = objects.front().colour;
        }
        return out;
    }

    // Parapets rise too far above the deck to be cut like it; they stand next to it, across its
    // direction.
    void grow() {
        m_grown = m_work;
        Grown::each([&](int x, int z) {
            if (m_work.at(x, z).deck.seen() || m_window.built(x, z) ||
                m_window.column(x, z).deck.seen())
                return;
            const LandSample& s = m_land.at(x, z);
            if (s.kind != LandKind::kGround && s.kind != LandKind::kThing)
                return;
            for (int dz = -1; dz <= 1; ++dz)
                for (int dx = -1; dx <= 1; ++dx)
                    if (is_edge(x, z, dx, dz, s.height)) {
                        m_grown.at(x, z) = m_work.at(x + dx, z + dz);
                        m_grown.at(x, z).deck = surface(x, z, s.height);
                        return;
                    }
        });
    }

    [[nodiscard]] bool is_edge(int x, int z, int dx, int dz, float height) {
        const FoundDeck& deck = m_work.at(x + dx, z + dz);
        if (!deck.deck.seen() || height < deck.deck.height - m_limits.level ||
            height > deck.deck.height + m_limits.parapet)
            return false;
        const DeckSection* section = m_sections.at(x + dx, z + dz);
        const auto [nx, nz] = kDeckDirections[static_cast<std::size_t>(section->direction)];
        const float across = -static_cast<float>(dx) * nx - static_cast<float>(dz) * nz;
        return std::abs(across) >= 0.7F && (across > 0 ? section->behind : section->before) > 0;
    }

    // Closes gaps, and sets the level of the land in gaps next to a deck, which would otherwise
    // take that of the deck.
    [[nodiscard]] std::unique_ptr<const FoundDecks> result() {
        auto out = std::make_unique<FoundDecks>();
        FoundDecks::each([&](int x, int z) {
            FoundDeck& here = out->at(x, z);
            here = m_grown.at(x, z);
            const Column& own = m_window.column(x, z);
            if (here.deck.seen() || m_window.built(x, z) || own.deck.seen())
                return;
            std::vector<const FoundDeck*> around;
            for (int dz = -1; dz <= 1; ++dz)
                for (int dx = -1; dx <= 1; ++dx)
                    if (const FoundDeck& next = m_grown.at(x + dx, z + dz); next.deck.seen())
                        around.push_back(&next);
            if (around.empty())
                return;
            const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
            std::nth_element(around.begin(), middle, around.end(),
                             [](const FoundDeck* a, const FoundDeck* b) {
                                 return a->deck.height < b->deck.height;
                             });
            if (around.size() >= kDecksAround)
                here = **middle;
            else if (!own.ground.seen() && !own.water.seen()) {
                here.below = (*middle)->below;
                here.over_water = false;
            }
        });
        return out;
    }

    using Grown = Grid<FoundDeck, FoundDecks::kMargin + 1>;
    static_assert(Grown::kMargin + 1 == Work::kMargin);

    const Window& m_window;
    const DeckLimits& m_limits;
    DeckLand m_land;
    DeckSections m_sections;
    Work m_work;
    Work m_grown;
};

}  // namespace

std::unique_ptr<const FoundDecks> find_decks(const Window& window, const ClassTable& classes,
                                             WaterAccess* water, const Settings::Bridges& settings,
                                             double voxel_m) {
    if (!settings.recognise)
        return nullptr;
    const DeckLimits limits(settings, voxel_m);
    const auto seeds = find_deck_seeds(window, limits);
    return seeds ? DeckFinder(window, classes, water, limits).find(*seeds) : nullptr;
}

namespace {

constexpr int kBridgedAround = 5;  // of eight

Surface find_deck(const Window& window, int x, int z) {
    const Column& own = window.column(x, z);
    if (own.bridged())
        return own.deck;
    std::array<const Surface*, 8> around{};
    std::size_t count = 0;
    for (int dz = -1; dz <= 1; ++dz)
        for (int dx = -1; dx <= 1; ++dx)
            if (const Column& c = window.column(x + dx, z + dz);
                (dx != 0 || dz != 0) && c.bridged())
                around[count++] = &c.deck;
    if (count < kBridgedAround)
        return {};
    const auto middle = around.begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(around.begin(), middle, around.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const Surface* a, const Surface* b) { return a->height < b->height; });
    return **middle;
}

}  // namespace

Margined<Surface> fill_decks(const Window& window, const FoundDecks* found) {
    Margined<Surface> out;
    if (window.any(&PatchColumns::any_deck))
        Margined<Surface>::each([&](int x, int z) { out.at(x, z) = find_deck(window, x, z); });
    if (found != nullptr)
        Margined<Surface>::each([&](int x, int z) {
            if (!out.at(x, z).seen())
                out.at(x, z) = found->at(x, z).deck;
        });
    return out;
}

void flow_beneath(const FoundDecks& found, double depth_m, WaterColumns& water) {
    FoundDecks::each([&](int x, int z) {
        const FoundDeck& f = found.at(x, z);
        if (!f.deck.seen() || !f.over_water || water.is_water(x, z))
            return;
        water.level.at(x, z) = f.below;
        if (x >= Margined<float>::kFirst && x < Margined<float>::kLast &&
            z >= Margined<float>::kFirst && z < Margined<float>::kLast)
            water.depth_m.at(x, z) = static_cast<float>(depth_m);
    });
}

void lower_ground(const FoundDecks& found, GroundHeights& ground) {
    FoundDecks::each([&](int x, int z) {
        const FoundDeck& f = found.at(x, z);
        if (f.below != f.below)
            return;  // NaN: nothing found here
        if (f.deck.seen())
            ground.at(x, z) = f.over_water ? kNoHeight : f.below;
        else if (ground.at(x, z) > f.below)
            ground.at(x, z) = f.below;
    });
}

void clear_crowns(const FoundDecks& found, double trunk_from_m, double voxel_m,
                  Margined<Crown>& crowns) {
    Margined<Crown>::each([&](int x, int z) {
        const FoundDeck& f = found.at(x, z);
        if (!f.deck.seen())
            return;
        Crown& crown = crowns.at(x, z);
        if (crown.seen() &&
            static_cast<double>(crown.height - f.deck.height) * voxel_m < trunk_from_m)
            crown = {};
    });
}

Margined<Surface> seen_decks(const Window& window) {
    Margined<Surface> out;
    Margined<Surface>::each([&](int x, int z) { out.at(x, z) = window.column(x, z).deck; });
    return out;
}

}  // namespace terravox::voxelize
