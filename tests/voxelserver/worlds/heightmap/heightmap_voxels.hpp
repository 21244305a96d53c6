#pragma once

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "voxelserver/worlds/heightmap/heightmap_world.hpp"

namespace terravox::test {

/// Reads voxels of any place through boxes.
class Voxels {
public:
    explicit Voxels(voxel::World& world, int level = 0) : m_world(world), m_level(level) {}
    std::optional<voxel::VoxelAttr> at(std::int32_t x, std::int32_t y, std::int32_t z) {
        const voxel::BoxKey key{m_level, voxel::floor_div(x, 64), voxel::floor_div(y, 256),
                                voxel::floor_div(z, 64)};
        if (!m_boxes.contains(key))
            m_boxes[key] = m_world.box(key);
        const auto& box = m_boxes[key];
        if (!box)
            return std::nullopt;
        return box->voxel(x - key.bx * 64, y - key.by * 256, z - key.bz * 64);
    }
    /// The highest solid voxel of a column; nullopt: it is air.
    std::optional<std::int32_t> top(std::int32_t x, std::int32_t z) {
        const auto& b = m_world.info().bounds;
        for (std::int32_t y = (b.max[1] >> m_level) + 1; y >= (b.min[1] >> m_level) - 1; --y)
            if (at(x, y, z))
                return y;
        return std::nullopt;
    }

private:
    voxel::World& m_world;
    int m_level;
    std::map<voxel::BoxKey, std::shared_ptr<const voxel::Box>> m_boxes;
};

inline std::unique_ptr<voxel::World> open(std::vector<std::filesystem::path> rasters,
                                          double voxel_m = 1) {
    heightmap::HeightmapOptions options;
    options.rasters = std::move(rasters);
    options.voxel_m = voxel_m;
    return heightmap::open_heightmap_world(options);
}

inline bool same(const std::shared_ptr<const voxel::Box>& a,
                 const std::shared_ptr<const voxel::Box>& b) {
    if (!a || !b)
        return !a && !b;
    return std::equal(a->blob().begin(), a->blob().end(), b->blob().begin(), b->blob().end());
}

}  // namespace terravox::test
