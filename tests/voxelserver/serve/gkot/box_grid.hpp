#pragma once

#include <map>
#include <optional>

#include "common/voxel/world.hpp"
#include "tests/common/voxel/scene.hpp"
#include "voxelserver/serve/gkot/gkot_reply.hpp"

namespace terravox::test {

/// Random boxes on both sides of all three axes; one in eight is air. Asks outside its bounds are
/// counted.
class BoxGrid {
public:
    explicit BoxGrid(std::uint64_t seed) {
        info.bounds = {{-64, -256, -64}, {64, 256, 64}};
        for (std::int32_t bx = -1; bx <= 0; ++bx)
            for (std::int32_t by = -1; by <= 0; ++by)
                for (std::int32_t bz = -1; bz <= 0; ++bz) {
                    const voxel::BoxKey key{0, bx, by, bz};
                    if ((seed * 8 + boxes.size()) % 11 != 3)
                        boxes[key] = random_scene(seed * 8 + boxes.size()).build(key, to_attr);
                    else
                        boxes[key] = nullptr;
                }
    }
    [[nodiscard]] std::optional<voxel::VoxelAttr> voxel(std::int64_t x, std::int64_t y,
                                                        std::int64_t z) const {
        const voxel::BoxKey key{0, static_cast<std::int32_t>(x >> 6),
                                static_cast<std::int32_t>(y >> 8),
                                static_cast<std::int32_t>(z >> 6)};
        const auto found = boxes.find(key);
        if (found == boxes.end() || !found->second)
            return std::nullopt;
        return found->second->voxel(static_cast<int>(x & 63), static_cast<int>(y & 255),
                                    static_cast<int>(z & 63));
    }
    [[nodiscard]] gkot::FetchBox fetch() {
        return [this](const voxel::BoxKey& key) -> std::shared_ptr<const voxel::Box> {
            ++requests;
            const auto found = boxes.find(key);
            if (found == boxes.end())
                ++requests_outside;
            return found == boxes.end() ? nullptr : found->second;
        };
    }

    voxel::WorldInfo info;
    std::map<voxel::BoxKey, std::shared_ptr<const voxel::Box>> boxes;
    int requests = 0;
    int requests_outside = 0;
};

}  // namespace terravox::test
