#include "voxelserver/make/voxelize/world/wide_ground.hpp"

#include <cmath>
#include <optional>

#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"

namespace terravox::voxelize {

/// Data around one patch.
struct WideGround::Around {
    /// Centres of water cells, voxels from the patch's first column.
    std::optional<ScatteredHeights> ground;
    float reach = 0;  ///< of the interpolation, voxels
    int rings = 0;    ///< of patches that were read
    /// Of the patch and its neighbours, when there is no ground; index (dz + 1) * 3 + dx + 1.
    std::array<float, 9> lowest{};
    std::size_t samples = 0;
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        constexpr std::size_t kTreeBytes = 16;  // nanoflann's share for each sample, about
        return sizeof *this + samples * (sizeof(ScatteredHeights::Sample) + kTreeBytes);
    }
};

std::shared_ptr<const WideGround::Around> WideGround::make(grid::PatchKey patch) {
    auto out = std::make_shared<Around>();
    const int cell = m_points.cell_voxels();
    std::vector<ScatteredHeights::Sample> samples;
    for (const int rings : kRings) {
        samples.clear();
        for (int dz = -rings; dz <= rings; ++dz)
            for (int dx = -rings; dx <= rings; ++dx) {
                const grid::PatchKey key{patch.px + dx, patch.pz + dz};
                const auto columns = m_points.columns(key);
                const water::CellPatch& cells = columns->cells;
                for (int z = 0; z < cells.side; ++z)
                    for (int x = 0; x < cells.side; ++x)
                        if (const float h = cells.at(x, z).ground; !std::isnan(h))
                            samples.push_back(
                                {static_cast<float>(dx * grid::kPatchSize + x * cell) +
                                     static_cast<float>(cell) / 2,
                                 static_cast<float>(dz * grid::kPatchSize + z * cell) +
                                     static_cast<float>(cell) / 2,
                                 h});
            }
        out->reach = static_cast<float>((rings + 1) * grid::kPatchSize) * 1.5f;
        out->rings = rings;
        if (samples.size() >= kEnough)
            break;
    }
    out->samples = samples.size();
    if (!samples.empty()) {
        out->ground.emplace(std::move(samples));
        return out;
    }
    for (int i = 0; i < 9; ++i)
        out->lowest[static_cast<std::size_t>(i)] =
            lowest_near({patch.px + i % 3 - 1, patch.pz + i / 3 - 1});
    return out;
}

// The lowest return of a patch and its neighbours: single patches may hold nothing but treetops.
float WideGround::lowest_near(grid::PatchKey patch) {
    float lowest = kNoHeight;
    for (int dz = -1; dz <= 1; ++dz)
        for (int dx = -1; dx <= 1; ++dx) {
            const grid::PatchKey key{patch.px + dx, patch.pz + dz};
            const float h = m_points.columns(key)->lowest;
            if (!std::isnan(h) && !(lowest <= h))
                lowest = h;
        }
    return lowest;
}

float WideGround::at(std::int32_t x, std::int32_t z, voxel::InputExtent& reach) {
    const grid::PatchKey patch{voxel::floor_div(x, grid::kPatchSize),
                               voxel::floor_div(z, grid::kPatchSize)};
    const auto around = m_around.get(
        patch, [&] { return make(patch); }, [](const auto& a) { return a->memory_bytes(); });
    reach.add(measure_reach(patch, around->rings));
    const float local_x = static_cast<float>(x - patch.x0()) + 0.5f;
    const float local_z = static_cast<float>(z - patch.z0()) + 0.5f;
    if (around->ground)
        return around->ground->at(local_x, local_z, around->reach);
    // Bilinear between the patches' centres, of those that hold any returns.
    const float u = local_x / grid::kPatchSize + 0.5f,
                v = local_z / grid::kPatchSize +
                    0.5f;  // 0.5 .. 1.5 within the patch; centres at 0, 1, 2
    const int i = u < 1 ? 0 : 1;
    const int k = v < 1 ? 0 : 1;
    const float fu = u - static_cast<float>(i);
    const float fv = v - static_cast<float>(k);
    float sum = 0;
    float weights = 0;
    for (const auto& [dx, dz, w] : {std::tuple{0, 0, (1 - fu) * (1 - fv)},
                                    {1, 0, fu * (1 - fv)},
                                    {0, 1, (1 - fu) * fv},
                                    {1, 1, fu * fv}}) {
        const float h = around->lowest[static_cast<std::size_t>((k + dz) * 3 + i + dx)];
        if (!std::isnan(h)) {
            sum += w * h;
            weights += w;
        }
    }
    return weights > 0 ? sum / weights : kNoHeight;
}

}  // namespace terravox::voxelize
