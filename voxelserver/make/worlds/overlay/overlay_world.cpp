#include "voxelserver/make/worlds/overlay/overlay_world.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/voxel/box_builder.hpp"

namespace terravox::overlay {
namespace {

using voxel::Box;
using voxel::BoxKey;

constexpr double kLargestLamp_m = 4;

double find_side(int level) noexcept {
    return static_cast<double>(std::int64_t{1} << level);
}

std::int32_t down(double v) noexcept {
    return static_cast<std::int32_t>(std::floor(v));
}

/// One past the highest voxel of a level that belongs to an object.
std::int32_t find_end(const AddedObject& object, int level) noexcept {
    return down(object.top / find_side(level) + 0.5);
}

std::int32_t find_bottom(const voxel::WorldInfo& info, int level) noexcept {
    return voxel::floor_div(info.bounds.min[1], std::int32_t{1} << level);
}

/// Heights of the objects' columns in a box and one column around it.
class ColumnTops {
public:
    static constexpr int kSide = voxel::kBoxSizeX + 2;

    explicit ColumnTops(const std::vector<const AddedObject*>& objects, const BoxKey& key)
        : m_tops(static_cast<std::size_t>(kSide) * kSide, kNone), m_lamps(m_tops.size()) {
        for (const AddedObject* object : objects)
            add(*object, key);
    }
    /// One past the object's highest voxel, in voxels of the level; kNone where there is none.
    /// @param x, z in [-1, 65)
    [[nodiscard]] std::int32_t at(int x, int z) const noexcept {
        return m_tops[compute_index(x, z)];
    }
    /// Whether the highest voxel emits light.
    [[nodiscard]] bool is_lamp(int x, int z) const noexcept { return m_lamps[compute_index(x, z)]; }
    static constexpr std::int32_t kNone = INT32_MIN;

private:
    [[nodiscard]] static std::size_t compute_index(int x, int z) noexcept {
        return static_cast<std::size_t>(z + 1) * kSide + static_cast<std::size_t>(x + 1);
    }
    void add(const AddedObject& object, const BoxKey& key) {
        const double side = find_side(key.level);
        const Footprint::Point middle = object.footprint.middle();
        const std::int32_t end = find_end(object, key.level);
        const std::int32_t first = key.bz * voxel::kBoxSizeZ;
        // The column in the object's middle may lie half outside of it.
        const int begin = std::max(down(object.footprint.min()[1] / side) - 1 - first, -1);
        const int end_z =
            std::min(down(object.footprint.max()[1] / side) + 2 - first, voxel::kBoxSizeZ + 1);
        for (int z = begin; z < end_z; ++z) {
            const std::int32_t vz = key.bz * voxel::kBoxSizeZ + z;
            // Once for each row: a polygon may have many corners.
            const std::vector<double> borders = object.footprint.crossings((vz + 0.5) * side);
            for (int x = -1; x <= voxel::kBoxSizeX; ++x) {
                const std::int32_t vx = key.bx * voxel::kBoxSizeX + x;
                const bool is_middle = vx == down(middle[0] / side) && vz == down(middle[1] / side);
                if (!is_middle && !Footprint::is_inside(borders, (vx + 0.5) * side))
                    continue;
                const std::size_t at = compute_index(x, z);
                if (end >= m_tops[at])
                    m_lamps[at] = object.is_lamp || (end == m_tops[at] && m_lamps[at]);
                m_tops[at] = std::max(m_tops[at], end);
            }
        }
    }
    std::vector<std::int32_t> m_tops;
    std::vector<bool> m_lamps;
};

void add_voxels(const Box& box, voxel::BoxBuilder& builder) {
    const int top = box.top();
    for (int z = 0; z < voxel::kBoxSizeZ; ++z)
        for (int x = 0; x < voxel::kBoxSizeX; ++x)
            for (int y = 0; y < top; ++y)
                if (const auto attr = box.voxel(x, y, z))
                    builder.add(x, z, y, y + 1, !voxel::see_through(attr->material));
}

}  // namespace

OverlayWorld::OverlayWorld(std::unique_ptr<voxel::World> base, std::vector<AddedObject> objects,
                           const std::string& text)
    : m_base(std::move(base)), m_objects(std::move(objects)), m_text(text), m_info(m_base->info()) {
    for (const AddedObject& object : m_objects) {
        const std::int32_t top = find_end(object, 0);
        m_info.bounds.max[1] = std::max(m_info.bounds.max[1], top);
        if (!m_info.framed.empty())
            m_info.framed.max[1] = std::max(m_info.framed.max[1], top);
        if (m_info.typical_heights)
            m_info.typical_heights->max = std::max(m_info.typical_heights->max, top);
    }
}

OverlayWorld::Objects OverlayWorld::objects_within(int level, std::int32_t bx, std::int32_t bz,
                                                   std::int32_t end_bx, std::int32_t end_bz) const {
    const double edge = find_side(level) * voxel::kBoxSizeX;
    // The column in an object's middle may lie half outside of it.
    const double margin = find_side(level);
    Objects out;
    for (const AddedObject& object : m_objects) {
        // It would hide the land, and light all of it.
        if (object.is_lamp && find_side(level) * m_info.voxel_m > kLargestLamp_m)
            continue;
        const Footprint::Point low = object.footprint.min();
        const Footprint::Point high = object.footprint.max();
        if (high[0] + margin >= bx * edge && low[0] - margin <= end_bx * edge &&
            high[1] + margin >= bz * edge && low[1] - margin <= end_bz * edge)
            out.push_back(&object);
    }
    return out;
}

std::shared_ptr<const Box> OverlayWorld::box(const BoxKey& key) {
    return with_objects(key, m_base->box(key));
}

void OverlayWorld::boxes(std::span<const BoxKey> keys, const voxel::TakeBox& take) {
    m_base->boxes(keys, [&](const BoxKey& key, voxel::BoxOutcome outcome) {
        if (!outcome.failure)
            outcome.box = with_objects(key, std::move(outcome.box));
        take(key, std::move(outcome));
    });
}

std::shared_ptr<const Box> OverlayWorld::with_objects(const BoxKey& key,
                                                      std::shared_ptr<const Box> base) const {
    const Objects objects = objects_at(key.level, key.bx, key.bz);
    if (objects.empty())
        return base;
    const ColumnTops tops(objects, key);
    const std::int32_t y0 = key.by * voxel::kBoxSizeY;
    const std::int32_t bottom = find_bottom(m_info, key.level);
    voxel::BoxBuilder builder;
    bool is_touched = false;
    for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
        for (int x = -1; x <= voxel::kBoxSizeX; ++x) {
            const std::int32_t top = tops.at(x, z);
            if (top == ColumnTops::kNone || top < y0 || bottom > y0 + voxel::kBoxSizeY)
                continue;
            const int from = std::max(bottom - y0, -1);
            const int to = std::min(top - y0, voxel::kBoxSizeY + 1);
            if (from >= to)
                continue;
            builder.add(x, z, from, to, true);
            is_touched |= x >= 0 && z >= 0 && x < voxel::kBoxSizeX && z < voxel::kBoxSizeZ;
        }
    if (!is_touched)
        return base;
    if (base)
        add_voxels(*base, builder);
    return builder.build(key, [&](int x, int y, int z) {
        // What was there before is filled up to the object's top.
        const std::int32_t top = tops.at(x, z);
        if (top != ColumnTops::kNone && y + y0 < top && y + y0 >= bottom) {
            const bool is_light = y + y0 == top - 1 && tops.is_lamp(x, z);
            return voxel::VoxelAttr{
                is_light ? voxel::Material::kLamp : voxel::Material::kPlain, 0, 0, 0, {}, 0};
        }
        return base ? base->voxel(x, y, z).value_or(voxel::VoxelAttr{}) : voxel::VoxelAttr{};
    });
}

voxel::ColumnExtent OverlayWorld::column(int level, std::int32_t bx, std::int32_t bz) {
    voxel::ColumnExtent out = m_base->column(level, bx, bz);
    for (const AddedObject* object : objects_at(level, bx, bz)) {
        const std::int32_t begin = voxel::floor_div(find_bottom(m_info, level), voxel::kBoxSizeY);
        const std::int32_t end =
            voxel::floor_div(find_end(*object, level) - 1, voxel::kBoxSizeY) + 1;
        if (begin >= end)
            continue;
        out = out.empty()
                  ? voxel::ColumnExtent{begin, end}
                  : voxel::ColumnExtent{std::min(out.by_begin, begin), std::max(out.by_end, end)};
    }
    return out;
}

bool OverlayWorld::may_hold(const voxel::BoxRange& range) {
    if (m_base->may_hold(range))
        return true;
    const auto& [min, max] = range;
    return !objects_within(min.level, min.bx, min.bz, max.bx, max.bz).empty();
}

std::string OverlayWorld::edition() const {
    const std::string of_base = m_base->edition();
    return (of_base.empty() ? "" : of_base + " ") + "with " + m_text;
}

std::optional<Surface> find_surface(voxel::World& world, std::int32_t x, std::int32_t z) {
    const std::int32_t bx = voxel::floor_div(x, voxel::kBoxSizeX);
    const std::int32_t bz = voxel::floor_div(z, voxel::kBoxSizeZ);
    const voxel::ColumnExtent extent = world.column(0, bx, bz);
    std::optional<std::int32_t> highest;
    constexpr std::int32_t kNone = INT32_MIN;
    std::int32_t opaque_top = kNone;  // of the opaque voxels that end at the one above
    for (std::int32_t by = extent.by_end - 1; by >= extent.by_begin; --by) {
        const auto box = world.box({0, bx, by, bz});
        for (int y = voxel::kBoxSizeY - 1; y >= 0; --y) {
            const auto attr = box ? box->voxel(x & 63, y, z & 63) : std::nullopt;
            if (!attr || (voxel::see_through(attr->material) &&
                          voxel::find_traits(attr->material).grain != voxel::Grain::kWater)) {
                opaque_top = kNone;
                if (!attr)
                    continue;
            }
            const std::int32_t top = by * voxel::kBoxSizeY + y + 1;
            highest = std::max(highest.value_or(top), top);
            const voxel::Grain grain = voxel::find_traits(attr->material).grain;
            if (grain == voxel::Grain::kTerrain || grain == voxel::Grain::kWater)
                return opaque_top == kNone ? Surface{top, true} : Surface{opaque_top, false};
            if (!voxel::see_through(attr->material) && opaque_top == kNone)
                opaque_top = top;
        }
    }
    return highest ? std::optional(Surface{*highest, false}) : std::nullopt;
}

std::optional<std::int32_t> find_ground(voxel::World& world, std::int32_t x, std::int32_t z) {
    const auto here = find_surface(world, x, z);
    if (!here || here->is_ground)
        return here ? std::optional(here->top) : std::nullopt;
    // What a building stands on is in no voxel: the ground around it counts.
    constexpr std::int32_t kFarthest = 128;
    std::vector<std::int32_t> around;
    for (int dx = -1; dx <= 1; ++dx)
        for (int dz = -1; dz <= 1; ++dz)
            for (std::int32_t i = 1; i <= kFarthest && (dx != 0 || dz != 0); ++i) {
                const auto there = find_surface(world, x + i * dx, z + i * dz);
                if (there && there->is_ground)
                    around.push_back(there->top);
                if (!there || there->is_ground)
                    break;
            }
    if (around.empty())
        return here->top;
    const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
    std::nth_element(around.begin(), middle, around.end());
    return *middle;
}

}  // namespace terravox::overlay
