#include "raytracer/analyse/raster/derived_bands.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "raytracer/analyse/raster/relief.hpp"

namespace terravox::analyse {
namespace {

/// Steps beyond which the ground is not interpolated, whatever the distance in metres: a block's
/// margin must stay small.
constexpr int kMaxReach = 256;

/// The derived values of a block's cells, row by row.
struct DerivedValues {
    std::vector<float> ground;
    std::vector<float> source;
    std::vector<float> above;
    std::vector<float> slope;
    std::vector<float> aspect;
    std::vector<float> shade;
};

class TerrainBlocks {
public:
    TerrainBlocks(CellFile& cells, double edge_m, const ReliefOptions& options)
        : m_cells(cells),
          m_edge_m(edge_m),
          m_options(options),
          m_radius(options.window / 2),
          m_reach(static_cast<int>(std::min<double>(options.fill_m / edge_m, kMaxReach))),
          // Slopes need filled ground around a cell, and each cell of it what it is filled from.
          m_margin(m_radius + m_reach) {}

    void derive(const CellRectangle& block) {
        read_around(block);
        fill_ground(m_ground, m_surface, m_reach, m_source);
        DerivedValues values;
        for (int y = 0; y < block.height; ++y)
            for (int x = 0; x < block.width; ++x)
                add_cell(x + m_margin, y + m_margin, values);
        write("dtm", block, values.ground);
        write("dtm_source", block, values.source);
        write("ndsm", block, values.above);
        write("slope", block, values.slope);
        write("aspect", block, values.aspect);
        write("hillshade", block, values.shade);
    }

private:
    void read_around(const CellRectangle& block) {
        const CellRectangle around{block.x0 - m_margin, block.y0 - m_margin,
                                   block.width + 2 * m_margin, block.height + 2 * m_margin};
        read("dsm", around, m_surface);
        read("dtm", around, m_ground);
        read("dtm_source", around, m_source);
        // Blocks that are finished have interpolated heights, from which nothing may follow: the
        // order of blocks would matter.
        for (std::size_t i = 0; i < m_ground.values.size(); ++i)
            if (m_source.values[i] == kInterpolatedGround)
                m_ground.values[i] = core::kNoData;
    }
    void add_cell(int x, int y, DerivedValues& to) const {
        const float ground = m_ground.at(x, y);
        to.ground.push_back(ground);
        to.source.push_back(m_source.at(x, y));
        to.above.push_back(ground == core::kNoData ? core::kNoData : m_surface.at(x, y) - ground);
        const CellPatch& relief = m_options.of == ReliefOf::kGround ? m_ground : m_surface;
        const auto gradient = gradient_at(relief, x, y, m_radius, m_edge_m);
        const auto aspect = gradient ? aspect_deg(*gradient) : std::nullopt;
        to.slope.push_back(gradient ? static_cast<float>(slope_deg(*gradient)) : core::kNoData);
        to.aspect.push_back(aspect ? static_cast<float>(*aspect) : core::kNoData);
        to.shade.push_back(gradient ? hillshade(*gradient, m_options.light_azimuth_deg,
                                                m_options.light_altitude_deg)
                                    : core::kNoData);
    }
    static int number_of(std::string_view name) {
        return band_number(core::AnalysisKind::kTerrain, name);
    }
    void read(std::string_view band, const CellRectangle& area, CellPatch& to) {
        to.width = area.width;
        to.height = area.height;
        m_cells.read(number_of(band), area, to.values);
    }
    void write(std::string_view band, const CellRectangle& area, std::vector<float>& values) {
        m_cells.write(number_of(band), area, values);
    }

    CellFile& m_cells;
    const double m_edge_m;
    const ReliefOptions& m_options;
    const int m_radius;
    const int m_reach;
    const int m_margin;
    CellPatch m_surface;
    CellPatch m_ground;
    CellPatch m_source;
};

}  // namespace

void derive_terrain(CellFile& cells, double edge_m, const ReliefOptions& options,
                    const std::stop_token& stop) {
    TerrainBlocks blocks(cells, edge_m, options);
    // Whole blocks of the file, and large: margins are read again for each.
    constexpr int kLarge_px = 512;
    const int side = cells.block_px() * std::max(kLarge_px / cells.block_px(), 1);
    for (int y = 0; y < cells.rows(); y += side)
        for (int x = 0; x < cells.columns(); x += side) {
            if (stop.stop_requested())
                throw util::Error(cells.attempt() + ": interrupted");
            blocks.derive(
                {x, y, std::min(side, cells.columns() - x), std::min(side, cells.rows() - y)});
        }
}

}  // namespace terravox::analyse
