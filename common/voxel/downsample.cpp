#include "common/voxel/downsample.hpp"

#include <algorithm>
#include <vector>

#include "common/voxel/box_builder.hpp"

namespace terravox::voxel {
namespace {

constexpr int kSolidFrom = 4;  // of eight children

struct Children {
    const std::array<std::shared_ptr<const Box>, 8>& boxes;
    /// Coordinates in fine voxels of the coarse box: x, z in [0, 128), y in [0, 512).
    [[nodiscard]] std::optional<VoxelAttr> voxel(int x, int y, int z) const noexcept {
        const auto& box = boxes[static_cast<std::size_t>(x >> 6 | (z >> 6) << 1 | (y >> 8) << 2)];
        return box ? box->voxel(x & 63, y & 255, z & 63) : std::nullopt;
    }
};

// The attributes of a coarse voxel: those that are seen win over the plain rock inside.
VoxelAttr merge(const Children& children, int x, int y, int z) {
    std::array<VoxelAttr, 8> found{};
    std::size_t count = 0;
    for (int dy = 1; dy >= 0; --dy)  // highest first: the first of equals wins
        for (int dz = 0; dz < 2; ++dz)
            for (int dx = 0; dx < 2; ++dx)
                if (const auto v = children.voxel(2 * x + dx, 2 * y + dy, 2 * z + dz); v && *v != VoxelAttr{}) found[count++] = *v;
    if (count == 0) return {};
    std::array<int, kMaterialCount> votes{};
    for (std::size_t i = 0; i < count; ++i) ++votes[static_cast<std::size_t>(found[i].material) % kMaterialCount];
    VoxelAttr best = found[0];
    for (std::size_t i = 1; i < count; ++i)
        if (votes[static_cast<std::size_t>(found[i].material) % kMaterialCount] > votes[static_cast<std::size_t>(best.material) % kMaterialCount]) best = found[i];
    int sum[3] = {}, coloured = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (found[i].material != best.material || !found[i].has_colour()) continue;
        sum[0] += found[i].colour.r, sum[1] += found[i].colour.g, sum[2] += found[i].colour.b, ++coloured;
    }
    if (coloured > 0) {
        const auto mean = [&](int s) { return static_cast<std::uint8_t>((s + coloured / 2) / coloured); };
        best.colour = {mean(sum[0]), mean(sum[1]), mean(sum[2])};
        best.flags |= VoxelAttr::kHasColour;
    }
    return best;
}

}  // namespace

std::shared_ptr<const Box> downsample(const BoxKey& key, const std::array<std::shared_ptr<const Box>, 8>& boxes) {
    if (std::all_of(boxes.begin(), boxes.end(), [](const auto& b) { return b == nullptr; })) return nullptr;
    const Children children{boxes};
    int top = 0;
    for (std::size_t i = 0; i < 8; ++i)
        if (boxes[i]) top = std::max(top, static_cast<int>(i >> 2) * kBoxSizeY + boxes[i]->top());
    BoxBuilder builder;
    for (int z = 0; z < kBoxSizeZ; ++z)
        for (int x = 0; x < kBoxSizeX; ++x)
            for (int y = 0; y < (top + 1) / 2; ++y) {
                int solid = 0, opaque = 0;
                for (int i = 0; i < 8; ++i) {
                    const auto v = children.voxel(2 * x + (i & 1), 2 * y + (i >> 2), 2 * z + (i >> 1 & 1));
                    if (!v) continue;
                    ++solid;
                    opaque += see_through(v->material) ? 0 : 1;
                }
                if (solid >= kSolidFrom) builder.add(x, z, y, y + 1, opaque * 2 > solid);
            }
    return builder.build(key, [&](int x, int y, int z) { return merge(children, x, y, z); });
}

}  // namespace terravox::voxel
