#include "voxelserver/make/voxelize/decks/deck_land.hpp"

#include "common/voxel/world.hpp"

namespace terravox::voxelize {

LandSample DeckLand::evaluate(int x, int z) {
    const Column& c = m_window.column(x, z);
    if (c.built_upon())
        return {c.roof.height, LandKind::kBuilt};
    if (c.bridged())
        return {c.deck.height, LandKind::kDeck};
    if (c.water.seen() && c.water_points >= c.ground_points)
        return {c.water.height, LandKind::kWater};
    if (c.ground.seen())
        return {c.ground.height, LandKind::kGround};
    if (const auto objects = m_window.objects(x, z); !objects.empty()) {
        const ObjectVoxel& lowest = objects.front();
        const ClassMeaning& m = m_classes.meaning[lowest.source_class];
        const bool thin =
            m.material == voxel::Material::kWire || m.material == voxel::Material::kTower;
        const bool solid = m.role == Role::kSurface || (m.role == Role::kObject && !thin);
        if (!solid)
            return {kNoHeight, LandKind::kUnknown};
        return {static_cast<float>(lowest.y) + static_cast<float>(lowest.fraction) / 256,
                LandKind::kThing};
    }
    const float level = body_level(x, z);
    return {level, level == level ? LandKind::kWater : LandKind::kUnknown};
}

float DeckLand::body_level(int x, int z) {
    if (m_water == nullptr)
        return kNoHeight;
    const std::int32_t cell = m_water->cell_voxels;
    const std::int32_t cx = voxel::floor_div(m_window.middle.x0() + x, cell);
    const std::int32_t cz = voxel::floor_div(m_window.middle.z0() + z, cell);
    if (cx != m_cell_x || cz != m_cell_z) {
        m_cell_x = cx;
        m_cell_z = cz;
        m_cell_level = m_water->level_near(cx, cz);
    }
    return m_cell_level;
}

}  // namespace terravox::voxelize
