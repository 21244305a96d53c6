#include "voxelserver/make/worlds/overlay/plane_world.hpp"

#include <algorithm>
#include <utility>

#include "common/util/cache.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/pyramid_world.hpp"

namespace terravox::overlay {
namespace {

using voxel::Box;
using voxel::BoxKey;

/// From the middle of the world to the plane's edges. Beyond, haze hides what there would be.
constexpr std::int32_t kRadius = 1 << 17;
/// Of the plane, in voxels of level 0: nobody sees it from below.
constexpr std::int32_t kThick = 4;

/// The bounds of a plane beneath a world.
voxel::VoxelBounds bounds_with_plane(const voxel::VoxelBounds& base) {
    voxel::VoxelBounds out = base;
    for (const std::size_t axis : {std::size_t{0}, std::size_t{2}}) {
        const std::int32_t middle = base.min[axis] + (base.max[axis] - base.min[axis]) / 2;
        out.min[axis] = std::min(base.min[axis], middle - kRadius);
        out.max[axis] = std::max(base.max[axis], middle + kRadius);
    }
    out.min[1] -= kThick;
    return out;
}

/// Adds the voxels of a box. What is hidden at its border has opaque neighbours in the next boxes:
/// with these it stays hidden, and takes no room.
void add_place(const Box& box, voxel::BoxBuilder& builder) {
    constexpr int kLastX = voxel::kBoxSizeX - 1;
    constexpr int kLastY = voxel::kBoxSizeY - 1;
    constexpr int kLastZ = voxel::kBoxSizeZ - 1;
    const int top = box.top();
    for (int z = 0; z <= kLastZ; ++z)
        for (int x = 0; x <= kLastX; ++x)
            for (int y = 0; y < top; ++y) {
                const auto attr = box.voxel(x, y, z);
                if (!attr)
                    continue;
                builder.add(x, z, y, y + 1, !voxel::see_through(attr->material));
                const bool at_border =
                    x == 0 || x == kLastX || z == 0 || z == kLastZ || y == 0 || y == kLastY;
                if (!at_border || !box.hidden(x, y, z))
                    continue;
                if (x == 0 || x == kLastX)
                    builder.add(x == 0 ? -1 : x + 1, z, y, y + 1, true);
                if (z == 0 || z == kLastZ)
                    builder.add(x, z == 0 ? -1 : z + 1, y, y + 1, true);
                if (y == 0 || y == kLastY)
                    builder.add(x, z, y == 0 ? -1 : y + 1, y == 0 ? 0 : y + 2, true);
            }
}

class PlaneWorld final : public voxel::World {
public:
    PlaneWorld(std::unique_ptr<voxel::World> base, Plane plane)
        : m_base(std::move(base)),
          m_material(plane == Plane::kSea ? voxel::Material::kWater : voxel::Material::kPlain),
          m_info(m_base->info()),
          m_coarse(std::size_t{16} << 20) {
        m_info.framed = m_info.bounds;
        m_info.bounds = bounds_with_plane(m_info.bounds);
        m_info.levels = voxel::levels_for(m_info.bounds);
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

    [[nodiscard]] std::shared_ptr<const Box> box(const BoxKey& key) override {
        voxel::check_level(m_info, key.level);
        const voxel::BoxRange all = voxel::boxes_over(m_info.bounds, key.level);
        const voxel::ColumnExtent plane = column_of_plane(key.level);
        if (key.by < std::min(all.min.by, plane.by_begin) ||
            key.by >= std::max(all.max.by, plane.by_end))
            return nullptr;
        if (!is_of_base(key))
            return plane_box(key, nullptr);
        if (key.level >= m_base->info().levels)
            return coarse_box(key);
        return with_plane(key, m_base->box(key));
    }

    void boxes(std::span<const BoxKey> keys, const voxel::TakeBox& take) override {
        std::vector<BoxKey> asked;
        for (const BoxKey& key : keys)
            if (key.level < m_base->info().levels && is_of_base(key))
                asked.push_back(key);
            else
                World::boxes({&key, 1}, take);
        if (asked.empty())
            return;
        m_base->boxes(asked, [&](const BoxKey& key, voxel::BoxOutcome outcome) {
            if (!outcome.failure)
                outcome.box = with_plane(key, std::move(outcome.box));
            take(key, std::move(outcome));
        });
    }

    [[nodiscard]] int preferred_batch() const noexcept override {
        return m_base->preferred_batch();
    }
    [[nodiscard]] int useful_concurrency(int threads) const noexcept override {
        return m_base->useful_concurrency(threads);
    }

    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        const voxel::ColumnExtent plane = column_of_plane(level);
        if (!is_of_base({level, bx, 0, bz}))
            return plane;
        const voxel::ColumnExtent base =
            level < m_base->info().levels ? m_base->column(level, bx, bz)
                                          : voxel::column_of_bounds(m_info.bounds, level, bx, bz);
        if (base.empty())
            return plane;
        return {std::min(plane.by_begin, base.by_begin), std::max(plane.by_end, base.by_end)};
    }

    [[nodiscard]] bool may_hold(const voxel::BoxRange& range) override {
        const int level = range.min.level;
        if (range.min.by * voxel::kBoxSizeY < find_top(level) &&
            range.max.by * voxel::kBoxSizeY > find_bottom(level))
            return true;
        return level >= m_base->info().levels || m_base->may_hold(range);
    }

    [[nodiscard]] std::vector<std::string> damage() const override { return m_base->damage(); }
    [[nodiscard]] std::string edition() const override {
        const std::string base = m_base->edition();
        return (base.empty() ? "" : base + " ") +
               (m_material == voxel::Material::kWater ? "in a sea" : "on a table");
    }
    void stop() noexcept override { m_base->stop(); }

private:
    /// One past the highest voxel of the plane. Where voxels are larger, by rounding: far away the
    /// step is less than a pixel.
    [[nodiscard]] std::int32_t find_top(int level) const noexcept {
        const std::int32_t side = std::int32_t{1} << level;
        return voxel::floor_div(m_base->info().bounds.min[1] + side / 2, side);
    }
    [[nodiscard]] std::int32_t find_bottom(int level) const noexcept {
        const std::int32_t side = std::int32_t{1} << level;
        return std::min(voxel::floor_div(m_info.bounds.min[1], side), find_top(level) - 1);
    }

    [[nodiscard]] voxel::ColumnExtent column_of_plane(int level) const noexcept {
        return {voxel::floor_div(find_bottom(level), voxel::kBoxSizeY),
                voxel::floor_div(find_top(level) - 1, voxel::kBoxSizeY) + 1};
    }

    /// Whether some of the world that stands on the plane may lie in a box's columns.
    [[nodiscard]] bool is_of_base(const BoxKey& key) const noexcept {
        const voxel::BoxRange base = voxel::boxes_over(m_base->info().bounds, key.level);
        return key.bx >= base.min.bx && key.bx < base.max.bx && key.bz >= base.min.bz &&
               key.bz < base.max.bz;
    }

    /// A box of the plane, with what stands on it.
    [[nodiscard]] std::shared_ptr<const Box> plane_box(const BoxKey& key, const Box* base) const {
        const std::int32_t y0 = key.by * voxel::kBoxSizeY;
        const int from = std::max(find_bottom(key.level) - y0, -1);
        const int to = std::min(find_top(key.level) - y0, voxel::kBoxSizeY + 1);
        if (to <= 0 || from >= voxel::kBoxSizeY || from >= to)
            return nullptr;
        voxel::BoxBuilder builder;
        const bool opaque = !voxel::see_through(m_material);
        for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
            for (int x = -1; x <= voxel::kBoxSizeX; ++x)
                builder.add(x, z, from, to, opaque);
        if (base != nullptr)
            add_place(*base, builder);
        // What lies there wins: on coarse levels the plane's height is rounded.
        return builder.build(key, [&](int x, int y, int z) {
            const auto attr = base != nullptr ? base->voxel(x, y, z) : std::nullopt;
            return attr.value_or(voxel::VoxelAttr{m_material, 0, 0, 0, {}, 0});
        });
    }

    [[nodiscard]] std::shared_ptr<const Box> with_plane(const BoxKey& key,
                                                        std::shared_ptr<const Box> base) const {
        if (!base)
            return plane_box(key, nullptr);
        auto out = plane_box(key, base.get());
        return out ? out : base;
    }

    [[nodiscard]] std::shared_ptr<const Box> coarse_box(const BoxKey& key) {
        return m_coarse.get(
            key,
            [&] {
                return voxel::downsample(
                    key,
                    voxel::Pyramid::children(key, [&](const BoxKey& child) { return box(child); }));
            },
            [](const auto& made) { return made ? made->memory_bytes() : std::size_t{64}; });
    }

    const std::unique_ptr<voxel::World> m_base;
    const voxel::Material m_material;
    voxel::WorldInfo m_info;
    util::Cache<BoxKey, Box, voxel::BoxKeyHash> m_coarse;
};

}  // namespace

std::unique_ptr<voxel::World> on_plane(std::unique_ptr<voxel::World> world, Plane plane) {
    if (!world->info().framed.empty() || world->info().bounds.empty())
        return world;
    return std::make_unique<PlaneWorld>(std::move(world), plane);
}

}  // namespace terravox::overlay
