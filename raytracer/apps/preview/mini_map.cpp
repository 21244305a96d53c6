#include "raytracer/apps/preview/mini_map.hpp"

#include <algorithm>

#include "raytracer/farm/processors/green_processor.hpp"

namespace terravox::preview {
namespace {

constexpr int kFirstStep = 8;

}  // namespace

MiniMap::MiniMap(blocks::BlockManager& blocks, const scene::Scene& scene, int edge_px)
    : m_picture(blocks, [&blocks](const shade::View& view) {
          return std::make_shared<processors::GreenProcessor>(view, blocks);
      }) {
    const voxel::WorldInfo& world = blocks.world_info();
    const voxel::VoxelBounds& b = world.framed_bounds();
    m_width = std::max(b.max[0] - b.min[0], 1);
    m_height = std::max(b.max[2] - b.min[2], 1);
    const double scale = edge_px / std::max(m_width, m_height);
    const int width = std::clamp(static_cast<int>(m_width * scale), 1, edge_px);
    const int height = std::clamp(static_cast<int>(m_height * scale), 1, edge_px);
    scene::Scene map;
    map.world = scene.world;
    map.generated = scene.generated;
    map.quality.materials = scene.quality.materials;
    map.quality.level = scene.quality.level;
    map.output.size_px = {width, height};
    map.quality.samples = 4;
    map.quality.ambient_occlusion = map.quality.reflections = map.quality.refraction = false;
    map.sky.visibility_km = 0;
    map.sun.altitude_deg = 45;
    map.sun.azimuth_deg = 315;  // as is usual for hill shading
    map.camera.projection = core::CameraProjection::kOrthographic;
    map.camera.space = core::CoordinateSpace::kVoxel;
    map.camera.inside_rock = true;
    const double x = b.min[0] + m_width / 2;
    const double z = b.min[2] + m_height / 2;
    map.camera.position = {x, b.max[1] + 100.0, z};
    map.camera.target = {x, b.max[1] + 0.0, z};
    map.camera.height_m = std::clamp(height * (m_width / width) * world.voxel_m, 0.001, 1e7);
    // As pixels are square, the picture may show a little more or less than the bounds along one
    // side.
    const double voxels_per_px = *map.camera.height_m / world.voxel_m / height;
    m_width = width * voxels_per_px;
    m_height = height * voxels_per_px;
    m_west = x - m_width / 2;
    m_north = z - m_height / 2;
    m_screen.resize(width, height);
    m_scene = map;
    begin();
}

void MiniMap::begin() {
    m_picture.start(m_scene, kFirstStep);
}

void MiniMap::work(Progressive::Clock::time_point until) {
    m_picture.work(until);
    for (const tiles::RenderTile& tile : m_picture.take_changes()) {
        show(*m_picture.film(), *m_picture.view(), m_picture.view()->scene.output, Layer::kBeauty,
             tile, m_screen);
        ++m_version;
    }
}

}  // namespace terravox::preview
