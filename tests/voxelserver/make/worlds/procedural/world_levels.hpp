#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>

#include "common/voxel/box_builder.hpp"
#include "common/voxel/world.hpp"

namespace terravox::test {

/// A box of any level made from boxes of level 0 by the downsampler.
inline std::shared_ptr<const voxel::Box> downsampled(voxel::World& world,
                                                     const voxel::BoxKey& key) {
    if (key.level == 0)
        return world.box(key);
    return voxel::downsample(key, voxel::Pyramid::children(key, [&](const voxel::BoxKey& child) {
                                 return downsampled(world, child);
                             }));
}

/// What a stack of boxes looks like from above.
struct FromAbove {
    std::map<voxel::Material, int> materials;  ///< columns
    double ground = 0;  ///< mean height of what is no plant and no water, level-0 voxels
    std::array<double, 3> colour{};  ///< mean, of the columns with one
    int columns = 0;
    int coloured = 0;
    [[nodiscard]] double share(voxel::Material m) const {
        return materials.contains(m) ? materials.at(m) / static_cast<double>(columns) : 0;
    }
    [[nodiscard]] double channel(std::size_t i) const { return colour[i] / coloured; }
    void add(const FromAbove& other) {
        for (const auto& [material, count] : other.materials)
            materials[material] += count;
        ground += other.ground;
        columns += other.columns;
        coloured += other.coloured;
        for (std::size_t i = 0; i < 3; ++i)
            colour[i] += other.colour[i];
    }
};

/// @param to_box gives the boxes of the stack @param by_begin, by_end which there are; every column
/// holds ground
inline FromAbove from_above(
    int level, std::int32_t bx, std::int32_t bz, std::int32_t by_begin, std::int32_t by_end,
    const std::function<std::shared_ptr<const voxel::Box>(const voxel::BoxKey&)>& to_box) {
    using voxel::Material;
    FromAbove out;
    std::array<bool, 4096> seen{};
    std::array<bool, 4096> grounded{};
    for (std::int32_t by = by_end - 1; by >= by_begin; --by) {
        const auto box = to_box({level, bx, by, bz});
        if (!box)
            continue;
        for (int i = 0; i < 4096; ++i) {
            for (int y = box->top() - 1; y >= 0 && !grounded[static_cast<std::size_t>(i)]; --y) {
                const auto voxel = box->voxel(i & 63, y, i >> 6);
                if (!voxel)
                    continue;
                if (!seen[static_cast<std::size_t>(i)]) {
                    seen[static_cast<std::size_t>(i)] = true;
                    ++out.materials[voxel->material];
                    ++out.columns;
                    if (voxel->has_colour()) {
                        out.colour[0] += voxel->colour.r;
                        out.colour[1] += voxel->colour.g;
                        out.colour[2] += voxel->colour.b;
                        ++out.coloured;
                    }
                }
                if (see_through(voxel->material) || voxel->material == Material::kTrunk)
                    continue;
                grounded[static_cast<std::size_t>(i)] = true;
                out.ground += std::ldexp(y + 1 + 256.0 * by, level);
            }
        }
    }
    return out;
}

}  // namespace terravox::test
