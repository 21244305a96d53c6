#include "raytracer/walk/level_cut.hpp"

#include "raytracer/scene/camera.hpp"

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
        const double near = detail > 0 ? static_cast<double>(1 << level) / (detail * pixel_rad) : 0;
        m_near2[l] = near * near;
    }
}

}  // namespace terravox::walk
