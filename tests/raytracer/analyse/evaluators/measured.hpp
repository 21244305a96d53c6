#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "raytracer/analyse/evaluators/analysis.hpp"
#include "raytracer/analyse/raster/cell_grid.hpp"
#include "raytracer/core/base/analysis_bands.hpp"
#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/core/output/picture.hpp"
#include "raytracer/core/shade/view.hpp"
#include "raytracer/farm/processors/thread_processor.hpp"
#include "raytracer/farm/render/passes/passes.hpp"
#include "tests/common/voxel/array_world.hpp"

namespace terravox::test {

/// The measured values of a world's cells, all of them in memory.
class Measured final : public output::TileSink {
public:
    struct Options {
        int threads = 1;
        int tile_px = 16;
        double edge_m = 1;
        std::optional<voxel::VoxelBounds> area = {};  ///< default: all
    };
    Measured(voxel::World& world, scene::Scene scene, const Options& options)
        : m_grid(analyse::grid_over(world.info(), options.area.value_or(world.info().bounds),
                                    options.edge_m)),
          m_bands(analyse::find_analysis(scene.analysis.kind).bands),
          m_count(analyse::count_measured(m_bands)),
          m_values(static_cast<std::size_t>(m_grid.columns) *
                   static_cast<std::size_t>(m_grid.rows) * m_count) {
        analyse::look_at_cells(m_grid, world.info(), scene);
        scene.quality.tile = {options.tile_px};
        blocks::BlockManager blocks(world, std::size_t{256} << 20);
        const shade::View view = shade::make_view(scene, blocks, analyse::measure);
        processors::ThreadProcessor processor(view, blocks, options.threads);
        m_counts = render::render_stream({view, processor, true, {}}, *this);
    }

    void add(const tiles::TileResult& result) override {
        std::size_t i = 0;
        result.tile.each_pixel([&](int x, int y) {
            for (std::size_t b = 0; b < m_count; ++b)
                m_values[index(x, y) + b] = result.bands.at(i++);
        });
    }

    /// @param x, z voxels of level 0
    /// @param band its name
    [[nodiscard]] float at(int x, int z, std::string_view band) const {
        const auto cell = [&](int voxel, std::int64_t first) {
            return static_cast<int>(std::floor(voxel / m_grid.edge_voxels)) -
                   static_cast<int>(first);
        };
        return m_values.at(index(cell(x, m_grid.west), cell(z, m_grid.north)) +
                           analyse::find_plane(m_bands, band));
    }
    [[nodiscard]] const std::vector<float>& values() const noexcept { return m_values; }
    [[nodiscard]] const render::RenderCounts& counts() const noexcept { return m_counts; }

private:
    [[nodiscard]] std::size_t index(int column, int row) const {
        if (column < 0 || row < 0 || column >= m_grid.columns || row >= m_grid.rows)
            throw std::out_of_range("a cell beyond the raster");
        return (static_cast<std::size_t>(row) * static_cast<std::size_t>(m_grid.columns) +
                static_cast<std::size_t>(column)) *
               m_count;
    }
    analyse::CellGrid m_grid;
    std::span<const analyse::RasterBand> m_bands;
    std::size_t m_count;
    std::vector<float> m_values;
    render::RenderCounts m_counts;
};

inline double value(const Measured& raster, int x, int z, std::string_view band) {
    return static_cast<double>(raster.at(x, z, band));
}

inline scene::Scene analysis_scene(core::AnalysisKind kind) {
    scene::Scene scene;
    scene.analysis.kind = kind;
    scene.quality.detail = 1;
    return scene;
}

}  // namespace terravox::test
