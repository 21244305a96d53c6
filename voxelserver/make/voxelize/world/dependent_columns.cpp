#include "voxelserver/make/voxelize/world/dependent_columns.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "voxelserver/make/voxelize/world/wide_ground.hpp"
#include "voxelserver/make/voxelize/world/world_facts.hpp"

namespace terravox::voxelize {
namespace {

using grid::ColumnRect;
using grid::PatchKey;
using voxel::InputExtent;

/// Patches around those that changed in which a column may read them without a gap in its ground:
/// its own window, and the first ring around a patch next to it (wide_ground.hpp).
constexpr std::int32_t kNear = 2;
constexpr std::int32_t kWidestGap = WideGround::kRings.back();

InputExtent list_patches(const ColumnRect& rect, std::int32_t around) {
    const auto below = [](std::int32_t v) { return voxel::floor_div(v, grid::kPatchSize); };
    return {below(rect.min_x) - around, below(rect.min_z) - around,
            below(rect.max_x - 1) + 1 + around, below(rect.max_z - 1) + 1 + around};
}

/// Patches between a patch and an extent, counted along the longer axis; 0: inside.
std::int32_t distance(PatchKey patch, const InputExtent& from) {
    return std::max({from.min_bx - patch.px, patch.px - from.max_bx + 1, from.min_bz - patch.pz,
                     patch.pz - from.max_bz + 1, 0});
}

InputExtent cut_to(const InputExtent& extent, const InputExtent& limits) {
    return {std::max(extent.min_bx, limits.min_bx), std::max(extent.min_bz, limits.min_bz),
            std::min(extent.max_bx, limits.max_bx), std::min(extent.max_bz, limits.max_bz)};
}

/// Looks at the columns that may read what changed, and at more where one of them reads farther,
/// until no more come.
///
/// What a column reads follows from what it has read before, so which columns read a square is the
/// same before and after it changed, and is found from the data as they are.
class Search {
public:
    Search(LidarWorld& world, std::vector<ColumnRect> changed, int threads)
        : m_world(world), m_threads(threads) {
        const voxel::VoxelBounds& bounds = world.info().bounds;
        m_limits = list_patches({bounds.min[0], bounds.min[2], bounds.max[0], bounds.max[2]}, 0);
        for (const ColumnRect& rect : changed)
            m_changed.push_back(list_patches(rect, world.shadow_patches()));
    }

    /// Columns where land was, which may be gone, are replaced by what is there now.
    void add_columns(const ColumnRect& rect) {
        const InputExtent extent = cut_to(list_patches(rect, 0), m_limits);
        for (std::int32_t z = extent.min_bz; z < extent.max_bz; ++z)
            for (std::int32_t x = extent.min_bx; x < extent.max_bx; ++x)
                m_out.dependent.insert({x, z});
    }

    DependentColumns run() {
        for (const InputExtent& changed : m_changed)
            want(grown(changed, kNear));
        look_at_wanted();
        for (const InputExtent& changed : m_changed)
            want_gaps(changed);
        look_at_wanted();
        choose_neighbours();
        return std::move(m_out);
    }

private:
    [[nodiscard]] static InputExtent grown(const InputExtent& extent, std::int32_t by) {
        return {extent.min_bx - by, extent.min_bz - by, extent.max_bx + by, extent.max_bz + by};
    }

    template <class Visit>
    void each_on_land(const InputExtent& extent, const Visit& visit) const {
        const InputExtent inside = cut_to(extent, m_limits);
        for (std::int32_t z = inside.min_bz; z < inside.max_bz; ++z)
            for (std::int32_t x = inside.min_bx; x < inside.max_bx; ++x)
                if (m_world.facts().touches_land(0, x, z))
                    visit(PatchKey{x, z});
    }

    void want(const InputExtent& extent) {
        each_on_land(extent, [&](PatchKey column) {
            if (m_seen.insert(column).second)
                m_wanted.push_back(column);
        });
    }

    void look_at_wanted() {
        while (!m_wanted.empty()) {
            const std::vector<PatchKey> some = std::exchange(m_wanted, {});
            std::vector<InputExtent> reaches(some.size());
            thread::parallel_for(some.size(), m_threads, [&](std::size_t i) {
                reaches[i] = has_in_window(some[i]) ? m_world.water_reach(some[i].px, some[i].pz)
                                                    : m_world.reach(some[i].px, some[i].pz);
            });
            for (std::size_t i = 0; i < some.size(); ++i)
                look_at(some[i], reaches[i]);
        }
    }

    /// Whether what changed is one of the nine patches that each column reads: then only its water
    /// leads farther.
    [[nodiscard]] bool has_in_window(PatchKey column) const {
        return std::any_of(m_changed.begin(), m_changed.end(), [&](const InputExtent& changed) {
            return distance(column, changed) <= 1;
        });
    }

    // What depends on a square through a body of water has a cell of it in or next to itself, and
    // one column that was looked at at first has another one: that column's reach holds the body.
    void look_at(PatchKey column, const InputExtent& reach) {
        const bool reads = std::any_of(
            m_changed.begin(), m_changed.end(),
            [&](const InputExtent& changed) { return !cut_to(reach, changed).empty(); });
        if (!reads)
            return;
        m_out.dependent.insert(column);
        want(grown(reach, 1));
    }

    /// Wants the columns next to patches whose ground may be found as far away as what changed:
    /// those around which smaller rings hold too little ground.
    void want_gaps(const InputExtent& changed) {
        std::vector<PatchKey> gaps;
        each_on_land(grown(changed, kWidestGap), [&](PatchKey patch) {
            const std::int32_t away = distance(patch, changed);
            if (away > WideGround::kRings.front() && !has_ground(patch, away, changed))
                gaps.push_back(patch);
        });
        for (const PatchKey& gap : gaps)
            want({gap.px - 1, gap.pz - 1, gap.px + 2, gap.pz + 2});
    }

    /// Whether a patch reads no ring that is as wide as it is away.
    [[nodiscard]] bool has_ground(PatchKey patch, std::int32_t away, const InputExtent& changed) {
        const auto wide =
            std::lower_bound(WideGround::kRings.begin(), WideGround::kRings.end(), away);
        const std::int32_t rings = *std::prev(wide);
        // Those near what changed are decoded already, and one mostly has enough.
        std::vector<std::pair<std::int32_t, PatchKey>> around;
        for (std::int32_t z = patch.pz - rings; z <= patch.pz + rings; ++z)
            for (std::int32_t x = patch.px - rings; x <= patch.px + rings; ++x)
                around.emplace_back(distance({x, z}, changed), PatchKey{x, z});
        std::sort(around.begin(), around.end());
        std::size_t cells = 0;
        for (const auto& [apart, key] : around) {
            cells += ground_cells(key);
            if (cells >= WideGround::kEnough)
                return true;
        }
        return false;
    }

    [[nodiscard]] std::size_t ground_cells(PatchKey patch) {
        const auto [found, is_new] = m_ground_cells.try_emplace(patch);
        if (is_new)
            found->second = m_world.ground_cells(patch.px, patch.pz);
        return found->second;
    }

    /// Some of those near what changed, evenly; where all of these depend on it, of those farther
    /// away, and at last of those in other islands.
    void choose_neighbours() {
        std::vector<PatchKey> others;
        for (std::int32_t near = kNear; others.empty() && near <= kWidestGap + kNear; near += kNear)
            others = independent(near);
        if (others.empty())
            others = other_islands();
        const std::size_t count = std::min(others.size(), DependentColumns::kNeighbours);
        for (std::size_t k = 0; k < count; ++k)
            m_out.neighbours.push_back(others[others.size() * (2 * k + 1) / (2 * count)]);
    }

    [[nodiscard]] std::vector<PatchKey> independent(std::int32_t near) const {
        std::set<PatchKey> out;
        for (const InputExtent& changed : m_changed)
            each_on_land(grown(changed, near), [&](PatchKey column) {
                if (!m_out.dependent.contains(column))
                    out.insert(column);
            });
        return {out.begin(), out.end()};
    }

    /// Some columns of each island that does not depend on the squares: where one of its columns
    /// does, those next to it were looked at, and so all of it.
    [[nodiscard]] std::vector<PatchKey> other_islands() const {
        std::set<PatchKey> out;
        for (const ColumnRect& island : m_world.facts().islands) {
            const InputExtent extent = cut_to(list_patches(island, 0), m_limits);
            if (extent.empty())
                continue;
            constexpr std::int64_t kCount = DependentColumns::kNeighbours;
            const auto at = [](std::int32_t min, std::int32_t max, std::int64_t k) {
                return min + static_cast<std::int32_t>((max - min) * (2 * k + 1) / (2 * kCount));
            };
            for (std::int64_t k = 0; k < kCount; ++k) {
                constexpr std::int64_t kStride = 3;  // coprime to the number: no two in one row
                const PatchKey column{at(extent.min_bx, extent.max_bx, k),
                                      at(extent.min_bz, extent.max_bz, k * kStride % kCount)};
                if (!m_out.dependent.contains(column))
                    out.insert(column);
            }
        }
        return {out.begin(), out.end()};
    }

    LidarWorld& m_world;
    std::vector<InputExtent> m_changed;  ///< in patches, with those that they shade
    const int m_threads;
    InputExtent m_limits;
    std::map<PatchKey, std::size_t> m_ground_cells;
    std::set<PatchKey> m_seen;
    std::vector<PatchKey> m_wanted;
    DependentColumns m_out;
};

}  // namespace

DependentColumns columns_that_depend_on(LidarWorld& world, const std::set<std::size_t>& changed,
                                        int threads, const WorldBefore& before) {
    const std::vector<SquareInfo>& squares = world.facts().squares;
    // As where columns are made: a rounded point may lie just outside its file's bounds.
    std::vector<ColumnRect> rects;
    for (const std::size_t i : changed)
        rects.push_back(squares[i].bounds.grown(1));
    for (const ColumnRect& rect : before.lay)
        rects.push_back(rect.grown(1));
    for (const std::size_t i : world.rescaled_files(rects, before.scales_are_known))
        rects.push_back(squares[i].bounds.grown(1));
    // Their light changes, and with it all of their colours.
    for (const ColumnRect& photograph : world.photographs_with_light_from(changed))
        rects.push_back(photograph);
    Search search(world, std::move(rects), threads);
    for (const ColumnRect& rect : before.lay)
        search.add_columns(rect.grown(1));
    return search.run();
}

std::set<std::size_t> squares_named(const LidarWorld& world, std::span<const std::string> names) {
    const std::vector<SquareInfo>& squares = world.facts().squares;
    std::set<std::size_t> out;
    for (const std::string& name : names) {
        std::size_t found = squares.size();
        for (std::size_t i = 0; i < squares.size(); ++i) {
            if (squares[i].name != name)
                continue;
            if (found < squares.size())
                throw util::UsageError(
                    "look for the square {}: two files have this name, {} and {}; allowed: one",
                    name, squares[found].file.string(), squares[i].file.string());
            found = i;
        }
        if (found == squares.size())
            throw util::UsageError(
                "look for the square {} among {}: there is none; allowed: names of files without "
                "folder and ending",
                name, squares.size());
        out.insert(found);
    }
    return out;
}

}  // namespace terravox::voxelize
