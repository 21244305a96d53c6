#pragma once

#include "common/util/cache.hpp"
#include "voxelserver/data/water/water_cells.hpp"
#include "voxelserver/make/voxelize/columns/point_set.hpp"
#include "voxelserver/make/voxelize/steps/surface.hpp"

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

}  // namespace terravox::voxelize
