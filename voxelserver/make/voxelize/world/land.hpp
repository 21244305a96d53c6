#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/stage_times.hpp"
#include "common/voxel/box.hpp"
#include "voxelserver/data/water/water_cells.hpp"
#include "voxelserver/make/voxelize/columns/point_set.hpp"
#include "voxelserver/make/voxelize/decks/bridges.hpp"
#include "voxelserver/make/voxelize/steps/buildings.hpp"
#include "voxelserver/make/voxelize/steps/ground_fill.hpp"
#include "voxelserver/make/voxelize/steps/runs.hpp"
#include "voxelserver/make/voxelize/steps/surface.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"
#include "voxelserver/make/voxelize/steps/water_fill.hpp"
#include "voxelserver/make/voxelize/world/wide_ground.hpp"

namespace terravox::voxelize {

/// Water cells for the search for water: those of the columns, with what images add. Thread-safe.
class CellStore final : public water::CellSource {
public:
    CellStore(PointSet& points, SurfaceStep& surface, std::size_t memory_bytes)
        : m_points(points), m_surface(surface), m_cells(memory_bytes) {}

    [[nodiscard]] std::shared_ptr<const water::CellPatch> cells(std::int32_t px,
                                                                std::int32_t pz) override {
        const grid::PatchKey key{px, pz};
        return m_cells.get(
            key,
            [&] {
                const auto columns = m_points.columns(key);
                auto cells = std::make_shared<water::CellPatch>(columns->cells);
                if (m_surface.finds_water() && columns->any)
                    m_surface.mark_wet(key, *columns, m_points.cell_voxels(), *cells);
                return cells;
            },
            [](const auto& c) {
                return sizeof *c + c->cells.capacity() * sizeof(water::WaterCell);
            });
    }

private:
    PointSet& m_points;
    SurfaceStep& m_surface;
    util::Cache<grid::PatchKey, water::CellPatch, grid::PatchKeyHash> m_cells;
};

/// What the steps of all patches of a world share. Thread-safe.
struct StepContext {
    /// Points, images, settings and times must outlive the context.
    /// @param images nullptr = none
    /// @param memory_bytes for the caches of the search for water and of the ground of wide gaps
    /// @param times receives the time of what is made for several patches at once
    StepContext(PointSet& points, const imagery::Orthophotos* images, const Settings& settings,
                std::size_t memory_bytes, util::StageTimes& times);

    PointSet& points;
    const Settings& settings;
    double voxel_m;
    std::unique_ptr<PhotoLights> photo_lights;  ///< nullptr: colours of images stay as they are
    SurfaceStep surface;
    const Tints& tints;  ///< empty where the step is switched off
    CellStore cells;
    water::WaterBodies bodies;
    WideGround wide_ground;
};

/// Decks of bridges.
struct Decks {
    std::unique_ptr<const FoundDecks> found;  ///< those without a bridge class; nullptr = none
    Margined<Surface> over;                   ///< the deck over each column, named or found
};

/// The boxes of one column of boxes, bottom first: that of index i has by = by_begin + i.
struct Boxes {
    std::int32_t by_begin = 0;
    std::vector<std::shared_ptr<const voxel::Box>> boxes;  ///< nullptr = air
};

/// What is known of one patch: the input of all steps, and the parts that they have made so far
/// (step.hpp). For one thread. A step reads a part with value(), which throws where the part has
/// not been made: that is an error in the table of steps.
struct Land {
    /// Half of the widest void that still counts as a gap between points; at most kWidestRadius
    /// voxels.
    static constexpr double kWidestGap_m = 28;

    Land(StepContext& shared, grid::PatchKey patch);

    /// The water bodies for steps that use them, or nullptr where they are switched off.
    [[nodiscard]] WaterAccess* water_bodies() noexcept {
        return shared.settings.steps.water_equalization ? &water_access : nullptr;
    }
    /// Extent of every patch that was read so far.
    [[nodiscard]] voxel::InputExtent& reach() noexcept { return water_access.reach; }

    StepContext& shared;
    Window window;
    Grid<char, Window::kMargin> in_bounds;  ///< 1 = inside the stated bounds of some file
    WaterAccess water_access;
    std::uint32_t steps_done = 0;  ///< bit i = the step of index i in steps() has run

    // The parts.
    std::optional<WaterColumns> water;
    std::optional<Decks> decks;
    std::optional<Margined<char>> covered;  ///< 0 = a hole, where there is nothing
    std::optional<GroundHeights> ground;
    std::optional<Margined<Roof>> roofs;
    std::optional<Margined<Crown>> crowns;
    std::optional<Buildings> buildings;
    std::optional<PlaceNumbers> numbers;
    std::optional<PatchAppearances> appearances;
    std::optional<SurfaceAppearance> surface;
    std::optional<PatchRuns> runs;
    std::optional<Boxes> boxes;
};

}  // namespace terravox::voxelize
