#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <utility>

#include "voxelserver/make/voxelize/steps/house_returns.hpp"

namespace terravox::voxelize {
namespace {

constexpr int kAround = 2;
constexpr int kAbove = 3;

bool near(const Surface& s, std::int32_t y) {
    return s.seen() && std::abs(static_cast<std::int32_t>(std::floor(s.height)) - y) <= kAbove;
}

bool anything_near(const Window& window, int x, int z, std::int32_t y, bool own) {
    for (const ObjectVoxel& o : window.objects(x, z)) {
        const std::int32_t dy = std::abs(o.y - y);
        if (dy <= kAbove && !(own && dy == 0))
            return true;
    }
    const Column& column = window.column(x, z);
    return near(column.roof, y) || near(column.deck, y) || near(column.ground, y);
}

}  // namespace

bool isolated(const Window& window, int x, int z, std::int32_t y) {
    // From the inside out: nearly every point has a close neighbour.
    if (anything_near(window, x, z, y, true))
        return false;
    for (int r = 1; r <= kAround; ++r)
        for (int dz = -r; dz <= r; ++dz)
            for (int dx = -r; dx <= r; dx += dz == -r || dz == r ? 1 : 2 * r)
                if (anything_near(window, x + dx, z + dz, y, false))
                    return false;
    return true;
}

namespace {

constexpr double kAround_m = 2;  // returns of one crown vary within this
constexpr std::int64_t kNoTop = std::numeric_limits<std::int64_t>::min();

}  // namespace

TreePlaces::TreePlaces(const Window& window, const ClassTable& classes, double voxel_m)
    : m_window(window),
      m_classes(classes),
      m_radius(std::clamp(static_cast<int>(std::lround(kAround_m / voxel_m)), 1, kMaxRadius)),
      m_tops(kCount, kNoTop),
      m_next(kCount),
      m_known(kCount) {
    // Each is read by all columns around it.
    constexpr int kPatch = grid::kPatchSize;
    for (int z = -kMargin; z < kPatch + kMargin; ++z)
        for (const auto& [from, to] :
             {std::pair{-kMargin, 0}, {0, kPatch}, {kPatch, kPatch + kMargin}}) {
            const PatchColumns& patch = window.patch_at(from, z);
            for (int x = from; x < to; ++x) {
                const auto i = static_cast<std::size_t>((z & 63) * kPatch + (x & 63));
                const std::uint32_t end = patch.objects_begin[i + 1];
                if (end != patch.objects_begin[i])
                    m_tops[index(x, z)] = top(patch.objects[end - 1]);
            }
        }
}

// The height of a column's highest return in 1/256 voxel, where it may be foliage.
std::int64_t TreePlaces::top(const ObjectVoxel& highest) const noexcept {
    const Role role = m_classes.meaning[highest.source_class].role;
    if (role != Role::kVegetation && role != Role::kSurface)
        return kNoTop;
    return std::int64_t{highest.y} * 256 + highest.fraction;
}

// Equally high columns: the northernmost, then the westernmost, so that all patches agree.
TreePlaces::Place TreePlaces::uphill(Place from) const noexcept {
    Place best = from;
    std::int64_t highest = m_tops[index(from.x, from.z)];
    for (int z = from.z - m_radius; z <= from.z + m_radius; ++z)
        for (int x = from.x - m_radius; x <= from.x + m_radius; ++x) {
            const std::int64_t height = m_tops[index(x, z)];
            const bool before = z < best.z || (z == best.z && x < best.x);
            if (height == kNoTop || height < highest || (height == highest && !before))
                continue;
            highest = height;
            best = {static_cast<std::int16_t>(x), static_cast<std::int16_t>(z)};
        }
    return best;
}

std::array<std::int32_t, 2> TreePlaces::at(int x, int z) {
    Place place{static_cast<std::int16_t>(x), static_cast<std::int16_t>(z)};
    for (int jump = 0; jump < kJumps; ++jump) {
        const std::size_t i = index(place.x, place.z);
        if (m_known[i] == 0) {
            m_next[i] = uphill(place);
            m_known[i] = 1;
        }
        const Place next = m_next[i];
        if (next.x == place.x && next.z == place.z)
            break;
        place = next;
    }
    return {m_window.middle.x0() + place.x, m_window.middle.z0() + place.z};
}

namespace {

constexpr std::size_t kCrownsAround = 5;     // of eight: a gap between points
constexpr std::size_t kCrownsAllAround = 6;  // the same, when a pulse passed through it
constexpr int kMaxWindow = 5;                // columns: what the margin allows
// Columns: farther than this from a plateau's edge, all of it ranks alike; a greater value would
// separate what lies within sight.
constexpr int kMaxDepth = 2;
// Radius over mean crown width: in a wood, a wider window would swallow neighbours. Unclassified
// returns are often so few that their heights vary within a crown: only the highest of a whole
// crown is a tree's top.
constexpr double kWindowShare = 0.25;
constexpr double kUnclassifiedShare = 0.5;
constexpr double kUnclassifiedReach_m = 2;
constexpr double kThick_m = 2;  // solid things of one level are no thicker
// A crown has at least this area over its height squared; masts, and wires, have less. In a window
// that shows only a part of it: over the radius squared.
constexpr double kSlender = 0.02;
constexpr double kSlenderInWindow = 0.95;
constexpr int kFewest = 6;           // columns, to tell whether something is solid
constexpr double kCrownShare = 0.5;  // of a tree's height: crowns are seldom longer
using Canopy = Grid<Crown, GroundHeights::kMargin>;
using Closed = Grid<Crown, GroundHeights::kMargin - 1>;
using Heights = Grid<float, Closed::kMargin>;
static_assert(Heights::kMargin >= Margined<Crown>::kMargin + kMaxWindow);

// Which columns are the tops of trees, by heights above the ground: on a slope, by absolute height
// the crown uphill would hide every one below it.
//
// One order ranks all columns, so that no two hide each other: higher first; among equals the one
// deeper inside its plateau (columns of equal height that touch), then the northern, then the
// western one. A top ranks before all columns in its window; and before all of its plateau and the
// columns touching that, within the widest window: so a flat crown has one trunk, and not at its
// edge. The depth of a far column may be known only in part, and then it hides no column that might
// rank before it.
class TreeTops {
public:
    TreeTops(const Closed& crowns, const GroundHeights& ground, double voxel_m)
        : m_voxel_m(voxel_m) {
        Heights::each([&](int x, int z) {
            m_heights.at(x, z) = crowns.at(x, z).height - ground.at(x, z);
        });  // NaN without a crown
    }

    /// Radius of the window in which a tree's top is the highest, columns.
    [[nodiscard]] double window_radius(double height_m, bool unclassified) const {
        const double width_m =
            2.51503 + 0.00901 * height_m * height_m;  // Popescu & Wynne, all kinds of trees
        const double radius_m = unclassified
                                    ? std::max(width_m * kUnclassifiedShare, kUnclassifiedReach_m)
                                    : width_m * kWindowShare;
        return std::clamp(radius_m / m_voxel_m, 1.0, static_cast<double>(kMaxWindow));
    }

    /// The crowns in a window.
    struct Around {
        float highest;    ///< voxels above its ground
        int columns = 0;  ///< of foliage in the upper half of the column's own height
    };
    [[nodiscard]] Around around(int x, int z, double radius) const {
        const int reach = static_cast<int>(radius);
        const float own = m_heights.at(x, z);
        Around out{own};
        for (int dz = -reach; dz <= reach; ++dz)
            for (int dx = -reach; dx <= reach; ++dx) {
                if (dx * dx + dz * dz > radius * radius)
                    continue;
                const float height = m_heights.at(x + dx, z + dz);
                out.highest = std::max(out.highest, height);  // passes over NaN
                out.columns += height >= own / 2 ? 1 : 0;
            }
        return out;
    }

    [[nodiscard]] bool is_top(int x, int z, double radius) const {
        const int reach = static_cast<int>(radius);
        const float own = m_heights.at(x, z);
        bool equal = false;
        for (int dz = -reach; dz <= reach; ++dz)
            for (int dx = -reach; dx <= reach; ++dx) {
                if (dx * dx + dz * dz > radius * radius)
                    continue;
                const float other = m_heights.at(x + dx, z + dz);
                if (other > own)
                    return false;
                equal = equal || (other == own && (dx != 0 || dz != 0));
            }
        if (equal && hidden_by_equals(x, z, radius))
            return false;
        return !hidden_by_plateau(x, z);
    }

private:
    // How deep a column lies inside its plateau: the reach of the largest square around it that is
    // as high; at most `most`.
    [[nodiscard]] int depth(int x, int z, int most) const {
        const float own = m_heights.at(x, z);
        for (int r = 1; r <= most; ++r)
            for (int i = -r; i <= r; ++i)
                for (const auto& [dx, dz] : {std::pair{i, -r}, {i, r}, {-r, i}, {r, i}})
                    if (m_heights.at(x + dx, z + dz) != own)
                        return r - 1;
        return most;
    }

    // Whether the equally high column at (dx, dz) from here certainly ranks before this one.
    [[nodiscard]] bool before(int x, int z, int own_depth, int dx, int dz) const {
        const int least = depth(
            x + dx, z + dz, std::min(kMaxDepth, kMaxWindow - std::max(std::abs(dx), std::abs(dz))));
        return least > own_depth || (least == own_depth && (dz < 0 || (dz == 0 && dx < 0)));
    }

    [[nodiscard]] bool hidden_by_equals(int x, int z, double radius) const {
        const int reach = static_cast<int>(radius);
        const int own_depth = depth(x, z, kMaxDepth);
        const float own = m_heights.at(x, z);
        for (int dz = -reach; dz <= reach; ++dz)
            for (int dx = -reach; dx <= reach; ++dx) {
                if ((dx == 0 && dz == 0) || dx * dx + dz * dz > radius * radius)
                    continue;
                if (m_heights.at(x + dx, z + dz) == own && before(x, z, own_depth, dx, dz))
                    return true;
            }
        return false;
    }

    // Whether, on the plateau from (x, z) as far as the widest window, there is a column that ranks
    // before this one, or a higher one next to the plateau.
    [[nodiscard]] bool hidden_by_plateau(int x, int z) const {
        constexpr int kSide = 2 * kMaxWindow + 1;
        struct Offset {
            int dx;
            int dz;
        };
        std::array<bool, kSide * kSide> met{};
        std::array<Offset, kSide * kSide> to_visit;
        std::size_t count = 0;
        const auto meet = [&](int dx, int dz) {
            bool& known =
                met[static_cast<std::size_t>((dz + kMaxWindow) * kSide + dx + kMaxWindow)];
            if (!known)
                to_visit[count++] = {dx, dz};
            known = true;
        };
        meet(0, 0);
        const float own = m_heights.at(x, z);
        const int own_depth = depth(x, z, kMaxDepth);
        for (std::size_t i = 0; i < count; ++i) {
            const Offset at = to_visit[i];
            if (i > 0 && before(x, z, own_depth, at.dx, at.dz))
                return true;
            for (int dz = std::max(at.dz - 1, -kMaxWindow); dz <= std::min(at.dz + 1, kMaxWindow);
                 ++dz)
                for (int dx = std::max(at.dx - 1, -kMaxWindow);
                     dx <= std::min(at.dx + 1, kMaxWindow); ++dx) {
                    const float next = m_heights.at(x + dx, z + dz);
                    if (next > own && i > 0)
                        return true;
                    if (next == own)
                        meet(dx, dz);
                }
        }
        return false;
    }

    double m_voxel_m;
    Heights m_heights;
};

class CrownFiller {
public:
    CrownFiller(const Window& window, const ClassTable& classes, const GroundHeights& ground,
                const Settings& settings, double voxel_m)
        : m_window(window),
          m_classes(classes),
          m_ground(ground),
          m_settings(settings.vegetation),
          m_houses(window, classes, ground, settings.vegetation, voxel_m),
          m_drop_isolated(settings.points.drop_isolated),
          m_voxel_m(voxel_m) {
        Canopy::each([&](int x, int z) {
            Crown& crown = m_canopy.at(x, z);
            find_crown(x, z, crown);
            m_any = m_any || crown.seen();
        });
        if (!m_any)
            return;
        Closed::each([&](int x, int z) { m_closed.at(x, z) = closed(x, z); });
        m_tops.emplace(m_closed, ground, voxel_m);
    }

    [[nodiscard]] bool any() const noexcept { return m_any; }

    // Into its place: a copy of what has just been written in parts waits for all of it.
    void put(int x, int z, Crown& out) const {
        out = m_closed.at(x, z);
        if (!out.seen())
            return;
        const double height_m = height_above_ground_m(x, z, out);
        const auto gap = static_cast<std::int32_t>(
            std::lround(std::max(m_settings.canopy_gap_m, kCrownShare * height_m) / m_voxel_m));
        for (int dz = -1; dz <= 1; ++dz)
            for (int dx = -1; dx <= 1; ++dx) {
                const Crown& next = m_closed.at(x + dx, z + dz);
                // Down to where the lower neighbour's foliage begins, so that they touch. A much
                // lower one is another plant.
                if (next.seen() && next.top < out.top && out.top - next.top <= gap)
                    out.bottom = std::min(out.bottom, next.top);
            }
        const bool unclassified = is_unclassified(out);
        const double radius = m_tops->window_radius(height_m, unclassified);
        bool tree = true;
        if (unclassified) {
            const TreeTops::Around around = m_tops->around(x, z, radius);
            const double least = std::min(kSlender * height_m * height_m / (m_voxel_m * m_voxel_m),
                                          kSlenderInWindow * radius * radius);
            tree = around.columns >= least && !solid(x, z);
            const float base =
                m_ground.at(x, z) + static_cast<float>(1 - kCrownShare) * around.highest;
            if (tree)
                out.bottom = std::min(out.bottom, static_cast<std::int32_t>(std::floor(base)));
        }
        out.trunk = tree && m_tops->is_top(x, z, radius);
        const std::int32_t clear = m_houses.clear_of_walls(x, z);
        out.trunk = out.trunk && out.top >= clear;
        out.bottom = std::min(std::max(out.bottom, clear), out.top);
    }

private:
    /// @param out none before
    void find_crown(int x, int z, Crown& out) const {
        const auto objects = m_window.objects(x, z);
        const float ground = m_ground.at(x, z);
        if (objects.empty() || ground != ground)
            return;
        for (std::size_t i = objects.size(); i-- > 0;) {
            const ObjectVoxel& o = objects[i];
            const Role role = m_classes.meaning[o.source_class].role;
            if (role != Role::kVegetation && role != Role::kSurface)
                continue;
            const float height = static_cast<float>(o.y) + static_cast<float>(o.fraction) / 256;
            if ((height - ground) * m_voxel_m < m_settings.trunk_from_m)
                return;
            if (m_houses.part(x, z, o) != HouseReturns::Part::kNone ||
                (m_drop_isolated && isolated(m_window, x, z, o.y)))  // a bird
                continue;
            out.top = out.bottom = o.y;
            out.top_voxel = o;
            out.height = height;
            out.passed = m_window.column(x, z).ground.seen() ||
                         (o.y - objects.front().y) * m_voxel_m > kThick_m;
            return;
        }
    }

    // Whether what is here is level, and hardly any pulse went through it: a deck, not a tree.
    [[nodiscard]] bool solid(int x, int z) const {
        const float own = m_closed.at(x, z).height;
        const int reach =
            std::clamp(static_cast<int>(std::lround(kThick_m / m_voxel_m)), 1, kMaxWindow);
        const auto within = static_cast<float>(kThick_m / m_voxel_m);
        int all = 0;
        int level = 0;
        int passed = 0;
        for (int dz = -reach; dz <= reach; ++dz)
            for (int dx = -reach; dx <= reach; ++dx) {
                const Crown& next = m_canopy.at(x + dx, z + dz);
                if (!next.seen())
                    continue;
                ++all;
                level += std::abs(next.height - own) <= within ? 1 : 0;
                passed += next.passed ? 1 : 0;
            }
        return all >= kFewest && level * 8 >= all * 7 && passed * 4 <= all;
    }

    [[nodiscard]] bool is_unclassified(const Crown& crown) const {
        return m_classes.meaning[crown.top_voxel.source_class].role == Role::kSurface;
    }

    [[nodiscard]] const Crown& closed(int x, int z) const {
        const Crown& own = m_canopy.at(x, z);
        // Where the ground or a roof was seen from above, there is no crown, unless unclassified
        // ones are all around: few returns come from them. Where there is no ground, nothing grows.
        const Column& column = m_window.column(x, z);
        const bool through = own.seen() || column.ground.seen();
        if ((own.seen() && !is_unclassified(own)) || m_ground.at(x, z) != m_ground.at(x, z) ||
            column.roof.seen() || column.water.seen() || column.deck.seen())
            return own;
        std::array<const Crown*, 8> around{};
        std::size_t count = 0;
        for (int dz = -1; dz <= 1; ++dz)
            for (int dx = -1; dx <= 1; ++dx)
                if (const Crown& next = m_canopy.at(x + dx, z + dz);
                    (dx != 0 || dz != 0) && next.seen())
                    around[count++] = &next;
        if (count < (through ? kCrownsAllAround : kCrownsAround))
            return own;
        const auto middle = around.begin() + static_cast<std::ptrdiff_t>(count / 2);
        std::nth_element(around.begin(), middle,
                         around.begin() + static_cast<std::ptrdiff_t>(count),
                         [](const Crown* a, const Crown* b) { return a->height < b->height; });
        const Crown& found = **middle;
        const auto gap = static_cast<float>(m_settings.canopy_gap_m / m_voxel_m);
        if (through && (!is_unclassified(found) || own.height + gap >= found.height))
            return own;
        return found.top < m_houses.clear_of_walls(x, z) ? own : found;
    }

    [[nodiscard]] double height_above_ground_m(int x, int z, const Crown& crown) const {
        return (static_cast<double>(crown.height) - static_cast<double>(m_ground.at(x, z))) *
               m_voxel_m;
    }

    const Window& m_window;
    const ClassTable& m_classes;
    const GroundHeights& m_ground;
    const Settings::Vegetation& m_settings;
    HouseReturns m_houses;
    bool m_drop_isolated;
    double m_voxel_m;
    bool m_any = false;
    Canopy m_canopy;
    Closed m_closed;
    std::optional<TreeTops> m_tops;  // set once there are crowns
};

}  // namespace

Margined<Crown> fill_crowns(const Window& window, const ClassTable& classes,
                            const GroundHeights& ground, const Settings& settings, double voxel_m) {
    Margined<Crown> out;
    if (!window.any(&PatchColumns::any_objects))
        return out;
    const CrownFiller filler(window, classes, ground, settings, voxel_m);
    if (filler.any())
        Margined<Crown>::each([&](int x, int z) { filler.put(x, z, out.at(x, z)); });
    return out;
}

}  // namespace terravox::voxelize
