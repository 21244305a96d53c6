#include "voxelserver/voxelize/world/dependent_columns.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "voxelserver/voxelize/points/brightness.hpp"
#include "voxelserver/voxelize/world/world_facts.hpp"

namespace terravox::voxelize {
namespace {

using grid::ColumnRect;
using grid::PatchKey;
using voxel::InputExtent;

/// Patches around one within which a gap without ground is filled (wide_ground.hpp), counted from
/// the margin of the patch that has the gap.
constexpr std::int32_t kGapPatches = 9;

ColumnRect rect_of(const InputExtent& extent) {
    // An extent of everything is wider than 32 bits of voxels.
    const auto edge = [](std::int64_t patch) {
        constexpr std::int64_t kFar = 1 << 30;
        return static_cast<std::int32_t>(std::clamp(patch * grid::kPatchSize, -kFar, kFar));
    };
    return {edge(extent.min_bx), edge(extent.min_bz), edge(extent.max_bx), edge(extent.max_bz)};
}

InputExtent patches_of(const ColumnRect& rect, std::int32_t around) {
    const auto below = [](std::int32_t v) { return voxel::floor_div(v, grid::kPatchSize); };
    return {below(rect.min_x) - around, below(rect.min_z) - around,
            below(rect.max_x - 1) + 1 + around, below(rect.max_z - 1) + 1 + around};
}

InputExtent cut_to(const InputExtent& extent, const InputExtent& limits) {
    return {std::max(extent.min_bx, limits.min_bx), std::max(extent.min_bz, limits.min_bz),
            std::min(extent.max_bx, limits.max_bx), std::min(extent.max_bz, limits.max_bz)};
}

/// Looks at columns, and at more where one of them reads farther, until no more come.
class Search {
public:
    Search(LidarWorld& world, std::vector<ColumnRect> changed, int threads)
        : m_world(world), m_changed(std::move(changed)), m_threads(threads) {
        const voxel::VoxelBounds& bounds = world.info().bounds;
        m_limits = patches_of({bounds.min[0], bounds.min[2], bounds.max[0], bounds.max[2]}, 0);
    }

    DependentColumns run() {
        for (const ColumnRect& rect : m_changed)
            want(patches_of(rect, kGapPatches + 1 + m_world.shadow_patches()));
        while (!m_wanted.empty()) {
            const std::vector<PatchKey> some = std::exchange(m_wanted, {});
            std::vector<InputExtent> reaches(some.size());
            thread::parallel_for(some.size(), m_threads, [&](std::size_t i) {
                reaches[i] = m_world.reach(some[i].px, some[i].pz);
            });
            for (std::size_t i = 0; i < some.size(); ++i)
                look_at(some[i], reaches[i]);
        }
        choose_neighbours();
        return std::move(m_out);
    }

private:
    void want(const InputExtent& extent) {
        const InputExtent inside = cut_to(extent, m_limits);
        for (std::int32_t z = inside.min_bz; z < inside.max_bz; ++z)
            for (std::int32_t x = inside.min_bx; x < inside.max_bx; ++x)
                if (m_world.facts().touches_land(0, x, z) && m_seen.insert({x, z}).second)
                    m_wanted.push_back({x, z});
    }

    // What depends on a square through a body of water has a cell of it in or next to itself, and
    // one column that was looked at at first has another one: that column's reach holds the body.
    void look_at(PatchKey column, const InputExtent& reach) {
        const ColumnRect rect = rect_of(reach);
        const bool reads = std::any_of(m_changed.begin(), m_changed.end(),
                                       [&](const ColumnRect& c) { return c.overlaps(rect); });
        if (!reads)
            return;
        m_out.dependent.insert(column);
        want({reach.min_bx - 1, reach.min_bz - 1, reach.max_bx + 1, reach.max_bz + 1});
    }

    /// Some of those that were looked at, evenly; where all of these depend on the squares, of
    /// those in other islands.
    void choose_neighbours() {
        std::vector<PatchKey> others;
        std::set_difference(m_seen.begin(), m_seen.end(), m_out.dependent.begin(),
                            m_out.dependent.end(), std::back_inserter(others));
        if (others.empty())
            others = other_islands();
        const std::size_t count = std::min(others.size(), DependentColumns::kNeighbours);
        for (std::size_t k = 0; k < count; ++k)
            m_out.neighbours.push_back(others[others.size() * (2 * k + 1) / (2 * count)]);
    }

    /// Some columns of each island that does not depend on the squares: where one of its columns
    /// does, those next to it were looked at, and so all of it.
    [[nodiscard]] std::vector<PatchKey> other_islands() const {
        std::set<PatchKey> out;
        for (const ColumnRect& island : m_world.facts().islands) {
            const InputExtent extent = cut_to(patches_of(island, 0), m_limits);
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
    const std::vector<ColumnRect> m_changed;
    const int m_threads;
    InputExtent m_limits;
    std::set<PatchKey> m_seen;
    std::vector<PatchKey> m_wanted;
    DependentColumns m_out;
};

}  // namespace

DependentColumns columns_that_depend_on(LidarWorld& world, const std::set<std::size_t>& changed,
                                        int threads) {
    const std::vector<SquareInfo>& squares = world.facts().squares;
    // As where columns are made: a rounded point may lie just outside its file's bounds.
    std::vector<ColumnRect> rects;
    for (const std::size_t i : changed)
        rects.push_back(squares[i].bounds.grown(1));
    // Their light changes, and with it all of their colours.
    for (const ColumnRect& photograph : world.photographs_with_light_from(changed))
        rects.push_back(photograph);
    if (world.stats().flight_lines > 0) {
        const auto near = static_cast<std::int32_t>(kSharedScale_m / world.info().voxel_m) + 1;
        for (const SquareInfo& square : squares) {
            const bool is_near = std::any_of(changed.begin(), changed.end(), [&](std::size_t i) {
                return squares[i].bounds.grown(near).overlaps(square.bounds);
            });
            if (is_near)
                rects.push_back(square.bounds.grown(1));
        }
    }
    return Search(world, std::move(rects), threads).run();
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
                throw util::UsageError("look for the square " + name +
                                       ": two files have this name, " +
                                       squares[found].file.string() + " and " +
                                       squares[i].file.string() + "; allowed: one");
            found = i;
        }
        if (found == squares.size())
            throw util::UsageError("look for the square " + name + " among " +
                                   std::to_string(squares.size()) +
                                   ": there is none; allowed: names of files without folder and "
                                   "ending");
        out.insert(found);
    }
    return out;
}

}  // namespace terravox::voxelize
