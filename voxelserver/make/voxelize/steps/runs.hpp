#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/voxel/box.hpp"
#include "voxelserver/make/voxelize/steps/buildings.hpp"
#include "voxelserver/make/voxelize/steps/colour_variation.hpp"
#include "voxelserver/make/voxelize/steps/ground_fill.hpp"
#include "voxelserver/make/voxelize/steps/surface.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"
#include "voxelserver/make/voxelize/steps/water_fill.hpp"

namespace terravox::voxelize {

/// A vertical stretch of one column, [y0, y1) in absolute voxels.
struct Run {
    std::int32_t y0 = 0;
    std::int32_t y1 = 0;
    voxel::VoxelAttr attr;
    bool terrain = false;   ///< rock below the top voxel and its soil
    std::int16_t soil = 0;  ///< voxels of soil between the top voxel and the rock
};

/// The finished columns of a patch with a margin of one, from which boxes of any height are cut.
/// x, z in [-1, 65).
class PatchRuns {
public:
    static constexpr int kSide = grid::kPatchSize + 2;
    [[nodiscard]] std::span<const Run> column(int x, int z) const noexcept {
        const auto i = static_cast<std::size_t>((z + 1) * kSide + x + 1);
        return std::span(m_runs).subspan(m_begin[i], m_begin[i + 1] - m_begin[i]);
    }
    /// Lowest voxel of the 64 x 64 columns.
    [[nodiscard]] std::int32_t min_y() const noexcept { return m_min_y; }
    /// One past the highest voxel of the 64 x 64 columns; equals min_y() when there is nothing.
    [[nodiscard]] std::int32_t max_y() const noexcept { return m_max_y; }

private:
    friend class RunsBuilder;
    std::vector<Run> m_runs;
    std::vector<std::uint32_t> m_begin;
    std::int32_t m_min_y = 0;
    std::int32_t m_max_y = 0;
};

/// The results of all steps for a patch.
struct RunsInput {
    const Window& window;
    const ClassTable& classes;
    const Settings& settings;
    const Margined<char>& covered;  ///< 0: a hole, where there is nothing, not even rock
    const WaterColumns& water;
    const GroundHeights& ground;
    const Margined<Roof>& roofs;
    const Margined<Surface>& decks;
    const Margined<Crown>& crowns;
    /// Material of the surface, from colours; kAir = the class's own.
    const Margined<voxel::Material>& special;
    const Margined<char>& guessed;  ///< 1 = such a material is a guess, as no colour is known
    const PlaceNumbers& numbers;
    std::int32_t floor_y = 0;  ///< the terrain is solid from here up
    double voxel_m = 1;
};

/// Step "underground fill" and what stands on it: terrain, water with its bed, buildings down to
/// the local ground, bridge decks, plants and objects, as runs by rising y without overlaps.
[[nodiscard]] PatchRuns make_runs(const RunsInput& input);

/// Step "serialization": cuts one box out of the columns of its patch.
/// @param appearance colours seen from above: they replace the points' own colours for everything
/// but walls, water and what is below
/// @return nullptr when the box is air
[[nodiscard]] std::shared_ptr<const voxel::Box> serialize(const voxel::BoxKey& key,
                                                          const PatchRuns& runs,
                                                          const SurfaceAppearance& appearance);

}  // namespace terravox::voxelize
