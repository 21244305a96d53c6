#include "raytracer/core/walk/level_cut.hpp"

#include <algorithm>
#include <cmath>

#include "raytracer/core/scene/camera.hpp"

namespace terravox::walk {
namespace {

int level_for(double pixel_voxels, double detail, int finest, int coarsest) noexcept {
    // For axes that are not quite of unit length: voxels of exactly a pixel are fine enough.
    constexpr double kSlack = 1 + 1e-9;
    int level = finest;
    while (level < coarsest &&
           static_cast<double>(std::int64_t{2} << level) <= detail * pixel_voxels * kSlack)
        ++level;
    return level;
}

/// Square of the distance from the eye to the farthest point of the world, on the map, and to the
/// world's range of heights.
double farthest_corner2(const voxel::VoxelBounds& bounds, core::Vec3 eye, double dy) noexcept {
    const auto farthest = [&](double at, std::size_t axis) {
        return std::max(std::abs(bounds.min[axis] - at), std::abs(bounds.max[axis] - at));
    };
    const double dx = farthest(eye.x, 0);
    const double dz = farthest(eye.z, 2);
    return dx * dx + dy * dy + dz * dz;
}

LevelCut cut_for(const voxel::VoxelBounds& bounds, const scene::Camera& camera, double detail,
                 int finest, int coarsest) {
    if (camera.projection() == scene::Projection::kOrthographic)
        return {bounds, level_for(camera.pixel_voxels(0), detail, finest, coarsest)};
    return {bounds, camera.position(), camera.pixel_rad(), detail, finest, coarsest};
}

}  // namespace

LevelCut::LevelCut(const voxel::VoxelBounds& bounds, int level)
    : LevelCut(bounds, {}, 0, 0, level, level) {}

LevelCut::LevelCut(const voxel::VoxelBounds& bounds, const scene::Camera& camera, double detail,
                   int finest, int coarsest)
    : LevelCut(cut_for(bounds, camera, detail, finest, coarsest)) {}

LevelCut::LevelCut(const voxel::VoxelBounds& bounds, core::Vec3 eye, double pixel_rad,
                   double detail, int finest, int coarsest)
    : m_bounds(bounds),
      m_eye(eye),
      m_dy(outside(eye.y, bounds.min[1], bounds.max[1])),
      m_finest(finest),
      m_coarsest(detail > 0 ? coarsest : finest) {
    for (int level = 0; level <= m_coarsest; ++level) {
        const double near = detail > 0 ? static_cast<double>(1 << level) / (detail * pixel_rad) : 0;
        m_near2[static_cast<std::size_t>(level)] = near * near;
    }
    const double farthest2 = farthest_corner2(bounds, eye, m_dy);
    while (m_coarsest > m_finest && m_near2[static_cast<std::size_t>(m_coarsest)] > farthest2)
        --m_coarsest;
    const std::int32_t coarse = std::int32_t{1} << m_coarsest;
    for (std::size_t a = 0; a < 3; ++a) {
        m_entry_bounds.min[a] = voxel::floor_div(bounds.min[a], coarse) * coarse;
        m_entry_bounds.max[a] = (voxel::floor_div(bounds.max[a] - 1, coarse) + 1) * coarse;
    }
    for (int level = 0; level <= m_coarsest; ++level) {
        const auto l = static_cast<std::size_t>(level);
        // A ray that leaves the world among fine voxels may meet coarse ones that stick out,
        // farther on: it ends at the same bounds on all levels.
        for (std::size_t a = 0; a < 3; ++a) {
            m_level_bounds[l].min[a] = m_entry_bounds.min[a] >> level;
            m_level_bounds[l].max[a] = m_entry_bounds.max[a] >> level;
        }
    }
}

voxel::VoxelBounds within_horizon(const voxel::VoxelBounds& bounds,
                                  const scene::Camera& camera) noexcept {
    if (camera.projection() == scene::Projection::kOrthographic)
        return bounds;
    const core::Vec3 eye = camera.position();
    const double height = std::max(eye.y, static_cast<double>(bounds.max[1])) -
                          std::min(eye.y, static_cast<double>(bounds.min[1]));
    const double farthest = height / camera.pixel_rad();
    voxel::VoxelBounds out = bounds;
    for (const int a : {0, 2}) {
        const auto i = static_cast<std::size_t>(a);
        const double low =
            std::max(std::floor(eye[a] - farthest), static_cast<double>(bounds.min[i]));
        const double high =
            std::min(std::ceil(eye[a] + farthest), static_cast<double>(bounds.max[i]));
        if (!(low < high))
            return bounds;
        out.min[i] = static_cast<std::int32_t>(low);
        out.max[i] = static_cast<std::int32_t>(high);
    }
    return out;
}

}  // namespace terravox::walk
