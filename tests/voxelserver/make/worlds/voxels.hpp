#pragma once

#include <map>
#include <memory>
#include <optional>

#include "common/voxel/world.hpp"

namespace terravox::test {

/// The voxels of a level; each box is made once.
class Voxels {
public:
    explicit Voxels(voxel::World& world, int level = 0) : m_world(world), m_level(level) {}
    [[nodiscard]] std::optional<voxel::VoxelAttr> at(std::int32_t x, std::int32_t y,
                                                     std::int32_t z) {
        const voxel::BoxKey key{m_level, voxel::floor_div(x, 64), voxel::floor_div(y, 256),
                                voxel::floor_div(z, 64)};
        if (key != m_last_key) {
            m_last_key = key;
            auto found = m_boxes.find(key);
            if (found == m_boxes.end())
                found = m_boxes.emplace(key, m_world.box(key)).first;
            m_last = found->second.get();
        }
        return m_last != nullptr ? m_last->voxel(x & 63, y & 255, z & 63) : std::nullopt;
    }
    [[nodiscard]] voxel::Material material(std::int32_t x, std::int32_t y, std::int32_t z) {
        const auto found = at(x, y, z);
        return found ? found->material : voxel::Material::kAir;
    }
    /// The highest solid voxel of a column; nullopt: it is air.
    [[nodiscard]] std::optional<std::int32_t> top(std::int32_t x, std::int32_t z) {
        const auto& b = m_world.info().bounds;
        for (std::int32_t y = (b.max[1] >> m_level) + 1; y >= (b.min[1] >> m_level) - 1; --y)
            if (at(x, y, z))
                return y;
        return std::nullopt;
    }

private:
    voxel::World& m_world;
    const int m_level;
    std::map<voxel::BoxKey, std::shared_ptr<const voxel::Box>> m_boxes;
    voxel::BoxKey m_last_key{-1, 0, 0, 0};
    const voxel::Box* m_last = nullptr;
};

/// How many voxels of a world, and of two around it, are not what `expected(x, y, z)` says. Rock
/// that nothing can see stands for whatever is hidden there.
template <class Expected>
int differing_voxels(voxel::World& world, const Expected& expected) {
    const auto opaque = [&](int x, int y, int z) { return !voxel::see_through(expected(x, y, z)); };
    const auto hidden = [&](int x, int y, int z) {
        return opaque(x, y, z) && opaque(x - 1, y, z) && opaque(x + 1, y, z) &&
               opaque(x, y - 1, z) && opaque(x, y + 1, z) && opaque(x, y, z - 1) &&
               opaque(x, y, z + 1);
    };
    Voxels voxels(world);
    const voxel::VoxelBounds b = world.info().bounds;
    int wrong = 0;
    for (int y = b.min[1] - 2; y < b.max[1] + 2; ++y)
        for (int z = b.min[2] - 2; z < b.max[2] + 2; ++z)
            for (int x = b.min[0] - 2; x < b.max[0] + 2; ++x) {
                const voxel::Material there =
                    hidden(x, y, z) ? voxel::Material::kRock : expected(x, y, z);
                wrong += voxels.material(x, y, z) != there ? 1 : 0;
            }
    return wrong;
}

}  // namespace terravox::test
