#pragma once

#include <cstdint>

#include "common/voxel/material.hpp"
#include "raytracer/scene/camera.hpp"
#include "raytracer/scene/scene.hpp"
#include "raytracer/shade/colour.hpp"
#include "raytracer/shade/sky.hpp"
#include "raytracer/walk/walker.hpp"

namespace terravox {

/// What is common to all rays of a picture. Immutable and shared by all processors.
struct View {
    Scene scene;
    Camera camera;
    Sky sky;
    voxel::Palette palette;
    voxel::VoxelBounds bounds;  ///< of the world, voxels of scene.quality.level
    double voxel_m = 1;         ///< edge of a level-0 voxel
};

struct PixelSample {
    Colour colour;        ///< linear
    float alpha = 0;      ///< share of samples that hit the world
    float depth_m = 0;    ///< mean distance of those samples; infinity where none hit
};

/// Traces and shades pixels of a view: primary, shadow, reflection and water rays, with a simple sky, ambient light and haze.
/// One for each thread: it owns the thread's box reader.
class Shader {
public:
    Shader(const View& view, BlockManager& blocks);

    /// The mean over the pixel's samples. A function of the pixel alone.
    [[nodiscard]] PixelSample pixel(int x, int y);
    [[nodiscard]] std::uint64_t rays() const noexcept { return m_walker.rays(); }
    [[nodiscard]] std::uint64_t steps() const noexcept { return m_walker.steps(); }
    [[nodiscard]] std::uint64_t hole_rays() const noexcept { return m_hole_rays; }

private:
    [[nodiscard]] Ray to_level(const Ray& ray) const noexcept;
    [[nodiscard]] Colour trace(const Ray& ray, double& t, bool& found);
    [[nodiscard]] Colour shade(const Ray& ray, const Hit& hit, bool mirrors);
    [[nodiscard]] Colour lit(const Ray& ray, const Hit& hit);
    [[nodiscard]] Colour water(const Ray& ray, const Hit& hit);
    [[nodiscard]] Colour albedo(const Hit& hit) const;
    [[nodiscard]] float occlusion(const Hit& hit, Vec3 point);
    [[nodiscard]] bool in_shadow(Vec3 point, VoxelCoord outside);

    const View& m_view;
    BlockReader m_reader;
    Walker m_walker;
    double m_scale;  ///< level-0 voxels per voxel of the level
    std::uint64_t m_hole_rays = 0;
};

}  // namespace terravox
