#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "tests/bench/bench.hpp"

namespace terravox::bench {

/// The scene that tracers are compared on: by the same formula as that of the peers, N x N
/// columns, 256 high, one byte a voxel.
class NeutralScene {
public:
    static constexpr int kSide = 1024;
    static constexpr int kHeight = 256;
    static constexpr int kSeed = 7;
    static constexpr int kWidthPx = 1280;
    static constexpr int kHeightPx = 720;
    /// Where a pixel stands in an array of all, row by row.
    [[nodiscard]] static constexpr std::size_t pixel_index(int x, int y) noexcept {
        return static_cast<std::size_t>(y * kWidthPx + x);
    }

    /// Why it cannot be made: no script, no Python with NumPy. Empty: it can.
    [[nodiscard]] static std::string missing(const Context& context);
    /// Runs the script into the scratch folder, or takes what an earlier entry made. @throws Error
    explicit NeutralScene(const Context& context);

    /// 0 = air; outside everything is air.
    [[nodiscard]] std::uint8_t at(int x, int y, int z) const noexcept {
        const std::uint8_t* voxels = y >= 0 && y < kHeight ? column(x, z) : nullptr;
        return voxels != nullptr ? voxels[y] : std::uint8_t{0};
    }
    /// The kHeight voxels of a column, lowest first; nullptr outside.
    [[nodiscard]] const std::uint8_t* column(int x, int z) const noexcept {
        if (x < 0 || x >= kSide || z < 0 || z >= kSide)
            return nullptr;
        return &m_voxels[(static_cast<std::size_t>(x) * kSide + static_cast<std::size_t>(z)) *
                         kHeight];
    }
    [[nodiscard]] static voxel::VoxelBounds bounds() noexcept {
        return {{0, 0, 0}, {kSide, kHeight, kSide}};
    }

private:
    std::vector<std::uint8_t> m_voxels;
};

/// The scene as boxes of level 0, all made at once and kept.
class NeutralWorld final : public voxel::World {
public:
    /// @param threads that make boxes, at least 1
    NeutralWorld(const NeutralScene& scene, int threads);
    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override;
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override;
    [[nodiscard]] std::size_t memory_bytes() const noexcept;  ///< of all boxes

private:
    [[nodiscard]] static std::size_t index(std::int32_t bx, std::int32_t bz) noexcept;
    voxel::WorldInfo m_info;
    std::vector<std::shared_ptr<const voxel::Box>> m_boxes;
};

/// A camera on the scene; the same for every tracer.
struct NeutralView {
    const char* name;
    core::Vec3 position;
    core::Vec3 target;
    double fov_deg;  ///< vertical
    [[nodiscard]] scene::Camera camera() const {
        return {position, target, fov_deg, NeutralScene::kWidthPx, NeutralScene::kHeightPx};
    }
};
[[nodiscard]] std::array<NeutralView, 3> neutral_views() noexcept;  ///< bird, oblique and ground
[[nodiscard]] core::Vec3 neutral_sun() noexcept;  ///< direction towards it, unit length

}  // namespace terravox::bench
