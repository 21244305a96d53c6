#include "raytracer/core/walk/lamp_query.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

namespace terravox::walk {
namespace {

using voxel::Material;
using voxel::TreeCell;

constexpr std::int32_t kReach = 64;
constexpr int kGroupBits = 4;
// Around a box. What a thread keeps is bounded by it, whatever a world holds.
constexpr std::size_t kMostLamps = std::size_t{1} << 14;

/// Calls visit(x, y, z, attr) for each voxel of a box that may be visible.
template <class Visit>
void each_visible(const voxel::Box& box, const Visit& visit) {
    const TreeCell* const cells = box.cells().data();
    for (std::int32_t root = 0; root < voxel::Box::kRootCount; ++root)
        for (std::uint64_t top = cells[root].detail; top != 0; top &= top - 1) {
            const int at = std::countr_zero(top);
            const TreeCell& middle = cells[cells[root].compute_index(at)];
            const std::int32_t x = (at & 3) * 16;
            const std::int32_t y = root * 64 + (at >> 4) * 16;
            const std::int32_t z = (at >> 2 & 3) * 16;
            for (std::uint64_t bricks = middle.detail; bricks != 0; bricks &= bricks - 1) {
                const int in = std::countr_zero(bricks);
                const TreeCell& brick = cells[middle.compute_index(in)];
                for (std::uint64_t left = brick.detail; left != 0; left &= left - 1) {
                    const int bit = std::countr_zero(left);
                    visit(x + (in & 3) * 4 + (bit & 3), y + (in >> 4) * 4 + (bit >> 4),
                          z + (in >> 2 & 3) * 4 + (bit >> 2 & 3),
                          box.attrs()[brick.compute_index(bit)]);
                }
            }
        }
}

bool has_lamp(const voxel::Box& box) {
    return std::ranges::any_of(
        box.attrs(), [](const voxel::VoxelAttr& attr) { return attr.material == Material::kLamp; });
}

core::Vec3 lower(core::Vec3 one, core::Vec3 other) noexcept {
    return {std::min(one.x, other.x), std::min(one.y, other.y), std::min(one.z, other.z)};
}

/// @return index of the one that the number selects, where each has its weight's share of [0, 1);
/// the number becomes that within the share; -1: none has a weight
template <class Weight>
std::ptrdiff_t select(std::size_t first, std::size_t end, const Weight& measure_weight,
                      double& number, double& probability) {
    double sum = 0;
    for (std::size_t i = first; i < end; ++i)
        sum += measure_weight(i);
    std::ptrdiff_t out = -1;
    double left = number * sum;
    for (std::size_t i = first; i < end; ++i) {
        const double weight = measure_weight(i);
        if (!(weight > 0))
            continue;
        // Rounding may leave a rest behind the last one, which is taken then.
        out = static_cast<std::ptrdiff_t>(i);
        number = std::min(left / weight, 1.0);
        probability = weight / sum;
        left -= weight;
        if (left < 0)
            break;
    }
    return out;
}

}  // namespace

/// Of level-0 voxels; both ends are included.
struct LampQuery::Range {
    std::int32_t low[3], high[3];
};

/// A point of a face, for which a lamp is chosen.
struct LampQuery::Asked {
    core::Vec3 point;
    core::Vec3 normal;
    double reach;
};

double LampQuery::measure_reach(int level) noexcept {
    return static_cast<double>(std::int64_t{kReach} << level);
}

bool LampQuery::choose(const Hit& hit, core::Vec3 point, double number, LampChoice& out) {
    const Lamps* const near =
        around({hit.level, hit.voxel.x >> 6, hit.voxel.y >> 8, hit.voxel.z >> 6});
    if (near == nullptr)
        return false;
    m_holes.insert(near->holes.begin(), near->holes.end());
    out = {};
    if (near->are_too_many)
        return true;
    out.looked = true;
    const Asked at{point, core::to_normal(hit.face), measure_reach(hit.level)};
    double of_group = 0;
    double of_lamp = 0;
    const auto group_weight = [&](std::size_t i) {
        const Group& group = near->groups[i];
        return static_cast<double>(group.end - group.first) *
               importance(at, group, near->lamps[group.first].edge());
    };
    const std::ptrdiff_t found = select(0, near->groups.size(), group_weight, number, of_group);
    if (found < 0)
        return true;
    const Group& group = near->groups[static_cast<std::size_t>(found)];
    const auto lamp_weight = [&](std::size_t i) {
        const LampVoxel& lamp = near->lamps[i];
        const core::Vec3 middle = lamp.middle();
        return importance(at, {i, i + 1, middle, middle}, lamp.edge());
    };
    const std::ptrdiff_t lamp = select(group.first, group.end, lamp_weight, number, of_lamp);
    if (lamp < 0)
        return true;
    out.lamp = near->lamps[static_cast<std::size_t>(lamp)];
    out.probability = static_cast<float>(of_group * of_lamp);
    return true;
}

// How likely a lamp of a group is to be chosen, relative to others: as the light at the point of a
// ball in the nearest place of the group, of which the part in front of the face counts. More than
// nothing whenever that is true of one of its lamps.
double LampQuery::importance(const Asked& at, const Group& group, double edge) {
    double far2 = 0;
    double height = edge / 2;  // normals are along an axis, so no part of a lamp is higher
    for (int a = 0; a < 3; ++a) {
        const double low = group.low[a] - at.point[a];
        const double high = group.high[a] - at.point[a];
        const double near = std::clamp(0.0, low, high);
        far2 += near * near;
        height += std::max(low * at.normal[a], high * at.normal[a]);
    }
    if (!(far2 <= at.reach * at.reach) || height <= 0)
        return 0;
    const double near2 = std::max(far2, edge * edge);
    return edge * edge * std::min(height / std::sqrt(near2), 1.0) / near2;
}

// Sorts lamps into groups, so that many of them cost little more than few.
void LampQuery::group(Lamps& of) {
    const auto place = [](const LampVoxel& lamp) {
        return std::tuple(lamp.level, lamp.voxel.x >> kGroupBits, lamp.voxel.y >> kGroupBits,
                          lamp.voxel.z >> kGroupBits);
    };
    std::ranges::stable_sort(of.lamps, {}, place);
    for (std::size_t i = 0; i < of.lamps.size(); ++i) {
        const core::Vec3 middle = of.lamps[i].middle();
        if (i == 0 || place(of.lamps[i - 1]) != place(of.lamps[i]))
            of.groups.push_back({i, i, middle, middle});
        Group& group = of.groups.back();
        group.end = i + 1;
        group.low = lower(group.low, middle);
        group.high = -lower(-group.high, -middle);
    }
}

// The lamps of all boxes within reach of a box.
const LampQuery::Lamps* LampQuery::around(const voxel::BoxKey& key) {
    if (const auto found = m_around.find(key); found != m_around.end())
        return &found->second;
    forget_if_many();
    const voxel::VoxelBounds& bounds = m_cut.entry_bounds();
    const std::int32_t corner[3] = {key.bx * voxel::kBoxSizeX, key.by * voxel::kBoxSizeY,
                                    key.bz * voxel::kBoxSizeZ};
    const std::int32_t size[3] = {voxel::kBoxSizeX, voxel::kBoxSizeY, voxel::kBoxSizeZ};
    Range range{};
    bool empty = false;
    for (int a = 0; a < 3; ++a) {
        const auto i = static_cast<std::size_t>(a);
        const auto fine = [&](std::int32_t v) { return std::int64_t{v} << key.level; };
        range.low[a] = static_cast<std::int32_t>(
            std::max<std::int64_t>(fine(corner[a] - kReach), bounds.min[i]));
        range.high[a] = static_cast<std::int32_t>(
            std::min<std::int64_t>(fine(corner[a] + size[a] + kReach), bounds.max[i]) - 1);
        empty = empty || range.low[a] > range.high[a];
    }
    Lamps out;
    const int level = m_cut.coarsest();
    const int side = LevelCut::kSideBits + level;
    if (!empty)
        for (std::int32_t bx = range.low[0] >> side; bx <= range.high[0] >> side; ++bx)
            for (std::int32_t bz = range.low[2] >> side; bz <= range.high[2] >> side; ++bz)
                if (!collect(level, bx, bz, range, out))
                    return nullptr;
    if (out.are_too_many)
        out.lamps = {};
    else
        group(out);
    m_kept += 1 + out.lamps.size() + out.groups.size();
    return &m_around.emplace(key, std::move(out)).first->second;
}

// A column of boxes of `level`, or of finer ones.
bool LampQuery::collect(int level, std::int32_t bx, std::int32_t bz, const Range& range,
                        Lamps& out) {
    if (!m_cut.far_enough(level, bx, bz)) {
        const int side = LevelCut::kSideBits + level - 1;
        for (int quarter = 0; quarter < 4; ++quarter) {
            const std::int32_t x = bx * 2 + (quarter & 1);
            const std::int32_t z = bz * 2 + (quarter >> 1);
            if (range.high[0] >> side < x || range.low[0] >> side > x ||
                range.high[2] >> side < z || range.low[2] >> side > z)
                continue;
            if (!collect(level - 1, x, z, range, out))
                return false;
        }
        return true;
    }
    for (std::int32_t by = range.low[1] >> level >> 8; by <= range.high[1] >> level >> 8; ++by) {
        // Nothing that is found after that would change the answer.
        if (out.are_too_many)
            return true;
        const Lamps* const lamps = of_box({level, bx, by, bz});
        if (lamps == nullptr)
            return false;
        out.are_too_many =
            lamps->are_too_many || out.lamps.size() + lamps->lamps.size() > kMostLamps;
        out.lamps.insert(out.lamps.end(), lamps->lamps.begin(), lamps->lamps.end());
        out.holes.insert(out.holes.end(), lamps->holes.begin(), lamps->holes.end());
    }
    return true;
}

const LampQuery::Lamps* LampQuery::of_box(const voxel::BoxKey& key) {
    if (const auto found = m_of_box.find(key); found != m_of_box.end())
        return &found->second;
    const blocks::Block* const block = m_reader.get(key);
    if (block == nullptr) {
        m_missing = key;
        return nullptr;
    }
    Lamps out;
    if (block->hole)
        out.holes.push_back(key);
    if (block->box && has_lamp(*block->box))
        each_visible(*block->box, [&](int x, int y, int z, const voxel::VoxelAttr& attr) {
            if (attr.material == Material::kLamp && out.lamps.size() <= kMostLamps)
                out.lamps.push_back({{key.bx * voxel::kBoxSizeX + x, key.by * voxel::kBoxSizeY + y,
                                      key.bz * voxel::kBoxSizeZ + z},
                                     key.level,
                                     attr});
        });
    out.are_too_many = out.lamps.size() > kMostLamps;
    if (out.are_too_many)
        out.lamps = {};
    m_kept += 1 + out.lamps.size();
    return &m_of_box.emplace(key, std::move(out)).first->second;
}

// Some 60 MB at most, and not while the lamps of a place are collected.
void LampQuery::forget_if_many() {
    constexpr std::size_t kMost = std::size_t{1} << 19;
    if (m_kept <= kMost)
        return;
    m_around.clear();
    m_of_box.clear();
    m_kept = 0;
}

}  // namespace terravox::walk
