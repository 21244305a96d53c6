#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raytracer/scene/camera.hpp"
#include "raytracer/walk/walker.hpp"
#include "tests/bench/bench.hpp"

namespace terravox::bench {

/// The scene that tracers are compared on: made by the shared script bench/voxel_scene.py, N x N columns, 256 high, one byte a voxel.
class NeutralScene {
public:
    static constexpr int kSide = 256, kHeight = 256, kSeed = 7;
    static constexpr int kWidthPx = 1280, kHeightPx = 720;

    /// Why it cannot be made: no script, no Python with NumPy. Empty: it can.
    [[nodiscard]] static std::string missing(const Context& context);
    /// Runs the script into the scratch folder, or takes what an earlier entry made. @throws Error
    explicit NeutralScene(const Context& context);

    /// 0 = air; outside everything is air.
    [[nodiscard]] std::uint8_t at(int x, int y, int z) const noexcept {
        const bool inside = x >= 0 && x < kSide && y >= 0 && y < kHeight && z >= 0 && z < kSide;
        return inside
                   ? m_voxels[(static_cast<std::size_t>(x) * kSide + static_cast<std::size_t>(z)) * kHeight + static_cast<std::size_t>(y)]
                   : std::uint8_t{0};
    }
    [[nodiscard]] static voxel::VoxelBounds bounds() noexcept { return {{0, 0, 0}, {kSide, kHeight, kSide}}; }
    [[nodiscard]] std::unique_ptr<voxel::World> make_world() const;

private:
    std::vector<std::uint8_t> m_voxels;
};

struct NamedCamera {
    const char* name;
    Camera camera;
};
/// Bird, oblique and ground view; the same for every tracer.
[[nodiscard]] std::array<NamedCamera, 3> neutral_cameras();
[[nodiscard]] Vec3 neutral_sun() noexcept;  ///< direction towards it, unit length

/// What one view of the scene took on one thread.
struct ViewTimes {
    double primary_s = 0, shadow_s = 0;
    std::size_t hits = 0, shadowed = 0;
    std::uint64_t primary_steps = 0;
    [[nodiscard]] double primary_rate() const noexcept {
        return NeutralScene::kWidthPx * NeutralScene::kHeightPx / primary_s / 1e6;
    }                                                                                                         ///< Mray/s
    [[nodiscard]] double shadow_rate() const noexcept { return static_cast<double>(hits) / shadow_s / 1e6; }  ///< Mray/s
};
/// One primary ray through each pixel's centre, then one from each hit towards the sun.
[[nodiscard]] ViewTimes walk_view(BlockReader& reader, const Camera& camera);

}  // namespace terravox::bench
