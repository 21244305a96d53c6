#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <vector>

#include "common/voxel/box_builder.hpp"
#include "common/voxel/world.hpp"

namespace terravox::test {

/// A world that is a plain array, one byte a voxel (its material), with boxes built from it: what
/// the walker is tested against.
class ArrayWorld : public voxel::World {
public:
    using Coord = std::array<std::int32_t, 3>;

    /// @param min, max voxels of `level`, half-open; air at first
    ArrayWorld(const Coord& min, const Coord& max, int level = 0) : m_min(min), m_level(level) {
        for (std::size_t a = 0; a < 3; ++a)
            m_size[a] = static_cast<std::size_t>(max[a] - min[a]);
        m_cells.resize(m_size[0] * m_size[1] * m_size[2]);
        m_info.title = "an array";
        m_info.levels = level + 1;
        for (std::size_t a = 0; a < 3; ++a) {
            m_info.bounds.min[a] = min[a] * (1 << level);
            m_info.bounds.max[a] = max[a] * (1 << level);
        }
        m_bounds = {min, max};
    }

    void set(std::int32_t x, std::int32_t y, std::int32_t z, voxel::Material material) {
        m_cells[index(x, y, z)] = static_cast<std::uint8_t>(material);
    }
    /// Fills [min, max), cut to the array.
    void fill(const Coord& min, const Coord& max, voxel::Material material) {
        for (std::int32_t y = std::max(min[1], m_bounds.min[1]);
             y < std::min(max[1], m_bounds.max[1]); ++y)
            for (std::int32_t z = std::max(min[2], m_bounds.min[2]);
                 z < std::min(max[2], m_bounds.max[2]); ++z)
                for (std::int32_t x = std::max(min[0], m_bounds.min[0]);
                     x < std::min(max[0], m_bounds.max[0]); ++x)
                    set(x, y, z, material);
    }
    /// Every voxel anew: to_material(x, y, z).
    template <class ToMaterial>
    void fill_with(const ToMaterial& to_material) {
        for (std::int32_t y = m_bounds.min[1]; y < m_bounds.max[1]; ++y)
            for (std::int32_t z = m_bounds.min[2]; z < m_bounds.max[2]; ++z)
                for (std::int32_t x = m_bounds.min[0]; x < m_bounds.max[0]; ++x)
                    set(x, y, z, to_material(x, y, z));
    }
    /// Asking for this box throws from now on. @param thrower what it throws; default: a
    /// runtime_error
    void make_hole(
        const voxel::BoxKey& key,
        std::function<void()> thrower = [] { throw std::runtime_error("the disk is gone"); }) {
        m_holes[key] = std::move(thrower);
    }

    /// Makes the box available again.
    void mend_hole(const voxel::BoxKey& key) { m_holes.erase(key); }

    /// Asking for this box does that first.
    void delay(const voxel::BoxKey& key, std::function<void()> before) {
        m_delays[key] = std::move(before);
    }

    [[nodiscard]] voxel::Material at(std::int32_t x, std::int32_t y,
                                     std::int32_t z) const noexcept {
        if (x < m_bounds.min[0] || y < m_bounds.min[1] || z < m_bounds.min[2] ||
            x >= m_bounds.max[0] || y >= m_bounds.max[1] || z >= m_bounds.max[2])
            return voxel::Material::kAir;
        return static_cast<voxel::Material>(m_cells[index(x, y, z)]);
    }
    [[nodiscard]] bool is_hole(std::int32_t x, std::int32_t y, std::int32_t z) const {
        return !m_holes.empty() && m_holes.contains({m_level, x >> 6, y >> 8, z >> 6});
    }
    /// Opaque with six opaque neighbours: the box knows such a voxel as plain rock.
    [[nodiscard]] bool hidden(std::int32_t x, std::int32_t y, std::int32_t z) const noexcept {
        const auto opaque = [&](std::int32_t i, std::int32_t j, std::int32_t k) {
            return !voxel::see_through(at(i, j, k));
        };
        return opaque(x, y, z) && opaque(x - 1, y, z) && opaque(x + 1, y, z) &&
               opaque(x, y - 1, z) && opaque(x, y + 1, z) && opaque(x, y, z - 1) &&
               opaque(x, y, z + 1);
    }
    /// In voxels of the world's level.
    [[nodiscard]] const voxel::VoxelBounds& level_bounds() const noexcept { return m_bounds; }

    [[nodiscard]] voxel::WorldInfo& editable_info() noexcept { return m_info; }
    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        ++m_requests;
        if (key.level != m_level)
            throw std::logic_error("box of another level asked: " + voxel::to_string(key));
        if (const auto delay = m_delays.find(key); delay != m_delays.end())
            delay->second();
        if (const auto hole = m_holes.find(key); hole != m_holes.end())
            hole->second();
        voxel::BoxBuilder builder;
        const std::int32_t x0 = key.bx * voxel::kBoxSizeX;
        const std::int32_t y0 = key.by * voxel::kBoxSizeY;
        const std::int32_t z0 = key.bz * voxel::kBoxSizeZ;
        for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
            for (int x = -1; x <= voxel::kBoxSizeX; ++x)
                for (int y = -1; y <= voxel::kBoxSizeY; ++y)
                    if (const auto m = at(x0 + x, y0 + y, z0 + z); m != voxel::Material::kAir)
                        builder.add(x, z, y, y + 1, !voxel::see_through(m));
        return builder.build(key, [&](int x, int y, int z) {
            return voxel::VoxelAttr{at(x0 + x, y0 + y, z0 + z), 0, 0, 0, {}, 0};
        });
    }
    [[nodiscard]] voxel::ColumnExtent column(int, std::int32_t, std::int32_t) override {
        const auto range = voxel::boxes_over(m_info.bounds, m_level);
        return {range.min.by, range.max.by};
    }
    [[nodiscard]] int level() const noexcept { return m_level; }
    [[nodiscard]] int requests() const noexcept { return m_requests; }

private:
    [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y, std::int32_t z) const noexcept {
        return (static_cast<std::size_t>(y - m_min[1]) * m_size[2] +
                static_cast<std::size_t>(z - m_min[2])) *
                   m_size[0] +
               static_cast<std::size_t>(x - m_min[0]);
    }
    Coord m_min;
    int m_level;
    std::array<std::size_t, 3> m_size{};
    std::vector<std::uint8_t> m_cells;
    voxel::VoxelBounds m_bounds;
    voxel::WorldInfo m_info;
    std::map<voxel::BoxKey, std::function<void()>> m_holes, m_delays;
    std::atomic<int> m_requests{0};
};

}  // namespace terravox::test
