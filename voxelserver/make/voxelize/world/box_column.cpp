#include "voxelserver/make/voxelize/world/box_column.hpp"

#include <algorithm>
#include <utility>

#include "voxelserver/make/voxelize/steps/photo_light.hpp"
#include "voxelserver/make/voxelize/world/step.hpp"

namespace terravox::voxelize {
namespace {

struct CoverageCounts {
    std::uint64_t covered = 0;
    std::uint64_t holes = 0;  ///< inside some file's bounds, but not covered
};

CoverageCounts count_coverage(const Land& land) {
    CoverageCounts out;
    for (int z = 0; z < grid::kPatchSize; ++z)
        for (int x = 0; x < grid::kPatchSize; ++x)
            if (land.in_bounds.at(x, z) != 0)
                ++(land.covered.value().at(x, z) != 0 ? out.covered : out.holes);
    return out;
}

/// Adds the reach of all water that the patch holds or may hold.
void ask_for_water(Land& land) {
    WaterAccess* const water = land.water_bodies();
    if (water == nullptr)
        return;
    // Steps need no level of cells that returned ground, or roofs.
    const grid::PatchKey patch = land.window.middle;
    const auto cells = water->cells.cells(patch.px, patch.pz);
    for (int z = 0; z < cells->side; ++z)
        for (int x = 0; x < cells->side; ++x)
            if (water->bodies.may_be_water(cells->at(x, z)))
                (void)water->level(patch.px * cells->side + x, patch.pz * cells->side + z);
}

voxel::InputExtent grown(const voxel::InputExtent& reach, std::int32_t by) noexcept {
    constexpr voxel::InputExtent kAll = water::kAnywhere;
    return {std::max(reach.min_bx, kAll.min_bx + by) - by,
            std::max(reach.min_bz, kAll.min_bz + by) - by,
            std::min(reach.max_bx, kAll.max_bx - by) + by,
            std::min(reach.max_bz, kAll.max_bz - by) + by};
}

}  // namespace

void BoxColumnMaker::count_holes(grid::PatchKey patch, std::uint64_t holes) {
    if (holes == 0)
        return;
    const std::lock_guard lock(m_holes_mutex);
    if (m_with_holes.insert(patch).second)
        m_hole_columns += holes;
}

BoxColumn BoxColumnMaker::make(grid::PatchKey patch) {
    Land land(m_context, patch);
    run_steps(land, part::kCoverage | part::kGround, m_times);
    const CoverageCounts counts = count_coverage(land);
    m_seen_columns += counts.covered + counts.holes;
    m_seen_holes += counts.holes;
    count_holes(patch, counts.holes);
    BoxColumn out;
    if (counts.covered > 0) {
        run_steps(land, part::kBoxes, m_times);
        static_cast<Boxes&>(out) = std::move(land.boxes.value());
    }
    out.reach = measure_reach(land);
    return out;
}

// The shadows on a patch's photograph come from the patches around.
voxel::InputExtent BoxColumnMaker::measure_reach(Land& land) const {
    return m_context.photo_lights ? grown(land.reach(), shadow_patches(m_context.voxel_m))
                                  : land.reach();
}

voxel::InputExtent BoxColumnMaker::reach(grid::PatchKey patch) {
    Land land(m_context, patch);
    run_steps(land, part::kCoverage | part::kGround, m_times);
    ask_for_water(land);
    return measure_reach(land);
}

voxel::InputExtent BoxColumnMaker::water_reach(grid::PatchKey patch) {
    Land land(m_context, patch);
    ask_for_water(land);
    return measure_reach(land);
}

std::vector<Tree> BoxColumnMaker::trees(grid::PatchKey patch) {
    Land land(m_context, patch);
    run_steps(land, part::kCoverage | part::kGround | part::kCrowns, m_times);
    std::vector<Tree> out;
    for (int z = 0; z < grid::kPatchSize; ++z)
        for (int x = 0; x < grid::kPatchSize; ++x)
            if (const Crown& crown = land.crowns->at(x, z);
                crown.seen() && crown.trunk && land.covered->at(x, z) != 0)
                out.push_back(
                    {patch.x0() + x, patch.z0() + z, crown.height, land.ground->at(x, z)});
    return out;
}

std::vector<float> BoxColumnMaker::ground_heights(grid::PatchKey patch) {
    Land land(m_context, patch);
    run_steps(land, part::kWater | part::kCoverage | part::kGround, m_times);
    std::vector<float> out;
    out.reserve(grid::kPatchColumns);
    for (int z = 0; z < grid::kPatchSize; ++z)
        for (int x = 0; x < grid::kPatchSize; ++x)
            out.push_back(land.covered->at(x, z) != 0 && !land.water->is_water(x, z)
                              ? land.ground->at(x, z)
                              : kNoHeight);
    return out;
}

}  // namespace terravox::voxelize
