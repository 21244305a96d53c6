#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "common/voxel/box.hpp"
#include "common/voxel/box_builder.hpp"

namespace terravox::test {

/// The plainest picture of a box: one byte a voxel, with a margin of one on every side. What the
/// 64-tree is tested against.
class Scene {
public:
    /// Marks [y0, y1) of a column. x, z in [-1, 65); y outside [-1, 257) is cut off.
    void add(int x, int z, int y0, int y1, bool opaque) {
        m_runs.push_back({x, z, y0, y1, opaque});
        for (int y = std::max(y0, -1); y < std::min(y1, voxel::kBoxSizeY + 1); ++y)
            m_cells[index(x, y, z)] |=
                static_cast<std::uint8_t>(opaque ? kSolid | kOpaque : kSolid);
    }
    [[nodiscard]] bool solid(int x, int y, int z) const {
        return (m_cells[index(x, y, z)] & kSolid) != 0;
    }
    [[nodiscard]] bool opaque(int x, int y, int z) const {
        return (m_cells[index(x, y, z)] & kOpaque) != 0;
    }
    /// Solid, and itself or one of its six neighbours lets light through.
    [[nodiscard]] bool visible(int x, int y, int z) const {
        if (!solid(x, y, z))
            return false;
        return !(opaque(x, y, z) && opaque(x - 1, y, z) && opaque(x + 1, y, z) &&
                 opaque(x, y - 1, z) && opaque(x, y + 1, z) && opaque(x, y, z - 1) &&
                 opaque(x, y, z + 1));
    }
    [[nodiscard]] int top() const {
        for (int y = voxel::kBoxSizeY; y > 0; --y)
            for (int z = 0; z < voxel::kBoxSizeZ; ++z)
                for (int x = 0; x < voxel::kBoxSizeX; ++x)
                    if (solid(x, y - 1, z))
                        return y;
        return 0;
    }
    [[nodiscard]] std::shared_ptr<const voxel::Box> build(
        const voxel::BoxKey& key, const voxel::BoxBuilder::AttrAt& attr_at) const {
        voxel::BoxBuilder builder;
        for (const Run& run : m_runs)
            builder.add(run.x, run.z, run.y0, run.y1, run.opaque);
        return builder.build(key, attr_at);
    }

private:
    static constexpr std::uint8_t kSolid = 1;
    static constexpr std::uint8_t kOpaque = 2;
    static constexpr std::size_t kSide = voxel::kBoxSizeX + 2;
    static constexpr std::size_t kHeight = voxel::kBoxSizeY + 2;
    struct Run {
        int x;
        int z;
        int y0;
        int y1;
        bool opaque;
    };
    static std::size_t index(int x, int y, int z) {
        return (static_cast<std::size_t>(z + 1) * kHeight + static_cast<std::size_t>(y + 1)) *
                   kSide +
               static_cast<std::size_t>(x + 1);
    }
    std::vector<std::uint8_t> m_cells = std::vector<std::uint8_t>(kSide * kSide * kHeight);
    std::vector<Run> m_runs;
};

/// Attributes that distinguish every voxel of a box from its neighbours; never plain rock.
inline voxel::VoxelAttr to_attr(int x, int y, int z) {
    voxel::VoxelAttr attr;
    attr.material =
        static_cast<voxel::Material>(2 + (x + 3 * y + 7 * z) % (voxel::kMaterialCount - 2));
    attr.source_class = static_cast<std::uint8_t>(x ^ y);
    attr.flags = voxel::VoxelAttr::kHasColour;
    attr.colour = {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
                   static_cast<std::uint8_t>(z)};
    return attr;
}

/// Hills with caves, trees above them and floating runs, in the box and its margin.
inline Scene random_scene(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const auto in = [&](int low, int high) {
        return low + static_cast<int>(random() % static_cast<std::uint64_t>(high - low));
    };
    Scene scene;
    const int base = in(-20, 240);
    const int rough = in(1, 40);
    for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
        for (int x = -1; x <= voxel::kBoxSizeX; ++x) {
            const int ground = base + in(0, rough);
            const int cave = in(0, 8) == 0 ? in(-1, 256) : 400;
            scene.add(x, z, -1, std::min(ground, cave), true);
            if (cave + 3 < ground)
                scene.add(x, z, cave + 3, ground, true);
            if (in(0, 4) == 0)
                scene.add(x, z, ground, ground + in(1, 9), false);
            if (in(0, 30) == 0) {
                const int y = in(-5, 258);
                scene.add(x, z, y, y + in(1, 30), in(0, 2) == 0);
            }
        }
    return scene;
}

}  // namespace terravox::test
