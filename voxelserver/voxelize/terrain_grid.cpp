#include "voxelserver/voxelize/terrain_grid.hpp"

#include <algorithm>
#include <cmath>

#include "voxelserver/voxelize/water_bodies.hpp"

namespace terravox::voxelize {
namespace {

constexpr double kPointsPerCell = 16;        // enough that an empty cell is a void, not bad luck
constexpr std::int64_t kMostCells = 24'000'000;  // about 700 MB while building, 200 MB after

struct Layer {
    std::int32_t width, height;
    std::vector<float> value, weight;
};

// Half the resolution: means of what is known.
Layer pull(const Layer& fine) {
    Layer out{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
    out.value.assign(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height), 0);
    out.weight = out.value;
    for (std::int32_t z = 0; z < fine.height; ++z)
        for (std::int32_t x = 0; x < fine.width; ++x) {
            const auto from = static_cast<std::size_t>(z) * static_cast<std::size_t>(fine.width) + static_cast<std::size_t>(x);
            const auto to = static_cast<std::size_t>(z / 2) * static_cast<std::size_t>(out.width) + static_cast<std::size_t>(x / 2);
            out.value[to] += fine.value[from] * fine.weight[from];
            out.weight[to] += fine.weight[from];
        }
    for (std::size_t i = 0; i < out.value.size(); ++i)
        if (out.weight[i] > 0) out.value[i] /= out.weight[i], out.weight[i] = std::min(out.weight[i], 1.0f);
    return out;
}

// Fills what is unknown from the coarser layer, bilinearly.
void push(const Layer& coarse, Layer& fine) {
    const auto at = [&](std::int32_t x, std::int32_t z) {
        x = std::clamp(x, 0, coarse.width - 1), z = std::clamp(z, 0, coarse.height - 1);
        return coarse.value[static_cast<std::size_t>(z) * static_cast<std::size_t>(coarse.width) + static_cast<std::size_t>(x)];
    };
    for (std::int32_t z = 0; z < fine.height; ++z)
        for (std::int32_t x = 0; x < fine.width; ++x) {
            const auto i = static_cast<std::size_t>(z) * static_cast<std::size_t>(fine.width) + static_cast<std::size_t>(x);
            if (fine.weight[i] >= 1) continue;
            const std::int32_t cx = x / 2, cz = z / 2, dx = x % 2 == 0 ? -1 : 1, dz = z % 2 == 0 ? -1 : 1;
            const float smooth = (9 * at(cx, cz) + 3 * at(cx + dx, cz) + 3 * at(cx, cz + dz) + at(cx + dx, cz + dz)) / 16;
            fine.value[i] = fine.weight[i] * fine.value[i] + (1 - fine.weight[i]) * smooth;
        }
}

}  // namespace

TerrainGrid::TerrainGrid(std::int32_t min_x, std::int32_t min_z, std::int32_t max_x, std::int32_t max_z, double density, double voxel_m)
    : m_voxel_m(voxel_m) {
    const auto area = [&](int shift) {
        return (static_cast<std::int64_t>(max_x - min_x) >> shift) * (static_cast<std::int64_t>(max_z - min_z) >> shift);
    };
    // At least 2 m, and as many points as tell a void from a gap between points.
    while ((1 << m_shift) * voxel_m < 2 || density * (1 << m_shift) * (1 << m_shift) < kPointsPerCell || area(m_shift) > kMostCells) {
        if (m_shift >= 12) break;
        ++m_shift;
    }
    m_cell = 1 << m_shift;
    m_origin_x = min_x >> m_shift, m_origin_z = min_z >> m_shift;
    m_width = ((max_x - 1) >> m_shift) - m_origin_x + 1;
    m_height = ((max_z - 1) >> m_shift) - m_origin_z + 1;
    m_cells.resize(static_cast<std::size_t>(m_width) * static_cast<std::size_t>(m_height));
}

void TerrainGrid::add_square(const Square& square, const ClassTable& classes) {
    constexpr int kBits = VoxelPoint::kFractionBits;
    constexpr float kOne = 1 << kBits;
    for (const VoxelPoint& p : square.all()) {
        const std::int32_t cx = cell_x(p.x >> kBits), cz = cell_z(p.z >> kBits);
        if (!inside(cx, cz)) continue;
        Cell& cell = m_cells[static_cast<std::size_t>(index(cx, cz))];
        const float y = static_cast<float>(p.y) / kOne;
        m_highest = std::max(m_highest, y);
        switch (classes.meaning[p.source_class].role) {
            case Role::kGround: cell.ground_sum += y, ++cell.ground_count, m_lowest = std::min(m_lowest, y); break;
            case Role::kWater: cell.water_sum += y, ++cell.water_count, m_lowest = std::min(m_lowest, y); break;
            case Role::kBridge: break;  // what is under a deck was not seen: it may be water
            default: ++cell.other_count; break;
        }
    }
}

void TerrainGrid::cover(std::int32_t min_x, std::int32_t min_z, std::int32_t max_x, std::int32_t max_z) {
    const std::int32_t x0 = std::max(cell_x(min_x), 0), x1 = std::min(cell_x(max_x - 1), m_width - 1);
    const std::int32_t z0 = std::max(cell_z(min_z), 0), z1 = std::min(cell_z(max_z - 1), m_height - 1);
    for (std::int32_t cz = z0; cz <= z1; ++cz)
        for (std::int32_t cx = x0; cx <= x1; ++cx) m_cells[static_cast<std::size_t>(index(cx, cz))].covered = true;
}

void TerrainGrid::finish() {
    if (!std::isfinite(m_highest)) m_highest = 0;
    if (!std::isfinite(m_lowest)) m_lowest = m_highest;
    fill_ground();
    find_water();
    m_cells = {};
}

void TerrainGrid::fill_ground() {
    // Ref: Gortler et al., "The Lumigraph" (pull-push), SIGGRAPH 1996.
    std::vector<Layer> layers(1);
    layers[0] = {m_width, m_height, std::vector<float>(m_cells.size()), std::vector<float>(m_cells.size())};
    for (std::size_t i = 0; i < m_cells.size(); ++i) {
        if (m_cells[i].ground_count == 0) continue;
        layers[0].value[i] = m_cells[i].ground_sum / static_cast<float>(m_cells[i].ground_count);
        layers[0].weight[i] = 1;
    }
    while (layers.back().width > 1 || layers.back().height > 1) layers.push_back(pull(layers.back()));
    if (layers.back().weight[0] <= 0) layers.back().value[0] = m_lowest;
    for (std::size_t i = layers.size() - 1; i > 0; --i) push(layers[i], layers[i - 1]);
    m_ground = std::move(layers[0].value);
}

void TerrainGrid::find_water() {
    std::vector<WaterCell> cells(m_cells.size());
    for (std::size_t i = 0; i < m_cells.size(); ++i) {
        const Cell& c = m_cells[i];
        cells[i].points = c.water_count;
        if (c.water_count > 0) cells[i].level = c.water_sum / static_cast<float>(c.water_count);
        // A cell of water may hold a few returns of the shore or of reeds.
        cells[i].open = c.covered && (c.ground_count + c.other_count == 0 || c.water_count > 2 * (c.ground_count + c.other_count));
    }
    m_water = find_water_bodies(cells, m_width, m_height, m_cell * m_voxel_m, m_voxel_m);
}

float TerrainGrid::ground(std::int32_t x, std::int32_t z) const noexcept {
    // Bilinear between cell centres.
    const auto at = [&](std::int32_t cx, std::int32_t cz) {
        return m_ground[static_cast<std::size_t>(index(std::clamp(cx, 0, m_width - 1), std::clamp(cz, 0, m_height - 1)))];
    };
    const float fx = (static_cast<float>(x - (m_origin_x << m_shift)) + 0.5f) / static_cast<float>(m_cell) - 0.5f;
    const float fz = (static_cast<float>(z - (m_origin_z << m_shift)) + 0.5f) / static_cast<float>(m_cell) - 0.5f;
    const float x0 = std::floor(fx), z0 = std::floor(fz), u = fx - x0, v = fz - z0;
    const auto cx = static_cast<std::int32_t>(x0), cz = static_cast<std::int32_t>(z0);
    return (at(cx, cz) * (1 - u) + at(cx + 1, cz) * u) * (1 - v) + (at(cx, cz + 1) * (1 - u) + at(cx + 1, cz + 1) * u) * v;
}

float TerrainGrid::water(std::int32_t x, std::int32_t z) const noexcept {
    const std::int32_t cx = cell_x(x), cz = cell_z(z);
    return inside(cx, cz) ? m_water[static_cast<std::size_t>(index(cx, cz))] : kNone;
}

float TerrainGrid::water_near(std::int32_t x, std::int32_t z) const noexcept {
    if (const float own = water(x, z); !std::isnan(own)) return own;
    for (const auto& [dx, dz] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}})
        if (const float w = water(x + dx * m_cell, z + dz * m_cell); !std::isnan(w)) return w;
    return kNone;
}

}  // namespace terravox::voxelize
