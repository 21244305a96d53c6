#pragma once

#include <memory>
#include <vector>

#include "tests/common/voxel/array_world.hpp"

namespace terravox::test {

/// A world of several levels: a voxel of a level is solid where any of the eight below it is, and
/// of their first material.
class PyramidWorld final : public voxel::World {
public:
    PyramidWorld(std::unique_ptr<ArrayWorld> finest, int levels) {
        m_levels.push_back(std::move(finest));
        m_info = m_levels.front()->info();
        m_info.levels = levels;
        for (int level = 1; level < levels; ++level)
            m_levels.push_back(coarser(*m_levels.back(), level));
    }
    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        return m_levels.at(static_cast<std::size_t>(key.level))->box(key);
    }
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        return m_levels.at(static_cast<std::size_t>(level))->column(level, bx, bz);
    }
    /// Voxels of the level.
    [[nodiscard]] voxel::Material at(int level, std::int32_t x, std::int32_t y,
                                     std::int32_t z) const {
        return m_levels.at(static_cast<std::size_t>(level))->at(x, y, z);
    }
    [[nodiscard]] ArrayWorld& level(int level) {
        return *m_levels.at(static_cast<std::size_t>(level));
    }

private:
    static std::unique_ptr<ArrayWorld> coarser(const ArrayWorld& fine, int level) {
        const voxel::VoxelBounds& b = fine.level_bounds();
        ArrayWorld::Coord min{};
        ArrayWorld::Coord max{};
        for (std::size_t a = 0; a < 3; ++a) {
            min[a] = voxel::floor_div(b.min[a], 2);
            max[a] = voxel::floor_div(b.max[a] - 1, 2) + 1;
        }
        auto out = std::make_unique<ArrayWorld>(min, max, level);
        out->fill_with([&](int x, int y, int z) {
            auto found = voxel::Material::kAir;
            for (int child = 7; child >= 0; --child)
                if (const auto m = fine.at(2 * x + (child & 1), 2 * y + (child >> 2),
                                           2 * z + (child >> 1 & 1));
                    m != voxel::Material::kAir)
                    found = m;
            return found;
        });
        return out;
    }
    std::vector<std::unique_ptr<ArrayWorld>> m_levels;
    voxel::WorldInfo m_info;
};

}  // namespace terravox::test
