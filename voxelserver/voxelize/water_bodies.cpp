#include "voxelserver/voxelize/water_bodies.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace terravox::voxelize {
namespace {

constexpr std::uint32_t kFewestPoints = 3;   // in a body: one stray class code makes no lake
constexpr double kFlatRange_m = 0.6;         // a body whose middle 80 % of levels span less is a lake
constexpr double kFlatSlope = 0.002;         // parts of a body with less slope are flat too (a lake that feeds a river)
constexpr double kFlatPartRange_m = 0.4;
constexpr int kSmoothingRounds = 24;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Grid {
    std::int32_t width, height;
    template <class Visit> void neighbours(std::int32_t i, const Visit& visit) const {
        const std::int32_t x = i % width, z = i / width;
        if (x > 0) visit(i - 1);
        if (x + 1 < width) visit(i + 1);
        if (z > 0) visit(i - width);
        if (z + 1 < height) visit(i + width);
    }
};

float median(std::vector<float> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// One connected body, by the indices of its cells.
class Body {
public:
    Body(const Grid& grid, const std::vector<WaterCell>& cells, std::vector<std::int32_t> members, double cell_m, double voxel_m)
        : m_grid(grid), m_cells(cells), m_members(std::move(members)), m_cell_m(cell_m), m_voxel_m(voxel_m) {}

    void level(std::vector<float>& out) const {
        std::vector<float> seen;
        for (const std::int32_t i : m_members)
            if (m_cells[static_cast<std::size_t>(i)].points > 0) seen.push_back(m_cells[static_cast<std::size_t>(i)].level);
        std::sort(seen.begin(), seen.end());
        const float low = seen[seen.size() / 10], high = seen[seen.size() - 1 - seen.size() / 10];
        if ((high - low) * m_voxel_m < kFlatRange_m) {
            const float middle = median(seen);
            for (const std::int32_t i : m_members) out[static_cast<std::size_t>(i)] = middle;
            return;
        }
        spread(out);
        smooth(out);
        flatten_parts(out);
    }

private:
    // Each cell without points takes the level of the nearest cell with points, counted through water.
    void spread(std::vector<float>& out) const {
        std::vector<std::int32_t> queue;
        for (const std::int32_t i : m_members) {
            const WaterCell& cell = m_cells[static_cast<std::size_t>(i)];
            out[static_cast<std::size_t>(i)] = cell.points > 0 ? cell.level : kNan;
            if (cell.points > 0) queue.push_back(i);
        }
        std::vector<bool> member(m_cells.size());
        for (const std::int32_t i : m_members) member[static_cast<std::size_t>(i)] = true;
        for (std::size_t head = 0; head < queue.size(); ++head)
            m_grid.neighbours(queue[head], [&](std::int32_t n) {
                if (!member[static_cast<std::size_t>(n)] || !std::isnan(out[static_cast<std::size_t>(n)])) return;
                out[static_cast<std::size_t>(n)] = out[static_cast<std::size_t>(queue[head])];
                queue.push_back(n);
            });
    }

    void smooth(std::vector<float>& out) const {
        std::vector<float> next(m_members.size());
        for (int round = 0; round < kSmoothingRounds; ++round) {
            for (std::size_t k = 0; k < m_members.size(); ++k) {
                float sum = out[static_cast<std::size_t>(m_members[k])];
                int count = 1;
                m_grid.neighbours(m_members[k], [&](std::int32_t n) {
                    // NaN: not of this body (bodies never touch, so any level next to a member is of its own body).
                    if (const float v = out[static_cast<std::size_t>(n)]; !std::isnan(v)) sum += v, ++count;
                });
                next[k] = sum / static_cast<float>(count);
            }
            for (std::size_t k = 0; k < m_members.size(); ++k) out[static_cast<std::size_t>(m_members[k])] = next[k];
        }
    }

    // Noise of a few centimetres must not make steps where a level lies at a voxel's border: parts without slope get one level.
    void flatten_parts(std::vector<float>& out) const {
        const auto step = static_cast<float>(kFlatSlope * m_cell_m / m_voxel_m);
        std::vector<bool> done(m_cells.size());
        for (const std::int32_t start : m_members) {
            if (done[static_cast<std::size_t>(start)]) continue;
            std::vector<std::int32_t> part{start};
            done[static_cast<std::size_t>(start)] = true;
            float low = out[static_cast<std::size_t>(start)], high = low;
            for (std::size_t head = 0; head < part.size(); ++head)
                m_grid.neighbours(part[head], [&](std::int32_t n) {
                    const float v = out[static_cast<std::size_t>(n)];
                    if (std::isnan(v) || done[static_cast<std::size_t>(n)] || std::abs(v - out[static_cast<std::size_t>(part[head])]) > step) return;
                    done[static_cast<std::size_t>(n)] = true;
                    low = std::min(low, v), high = std::max(high, v);
                    part.push_back(n);
                });
            if ((high - low) * m_voxel_m > kFlatPartRange_m) continue;
            std::vector<float> levels;
            for (const std::int32_t i : part) levels.push_back(out[static_cast<std::size_t>(i)]);
            const float middle = median(std::move(levels));
            for (const std::int32_t i : part) out[static_cast<std::size_t>(i)] = middle;
        }
    }

    const Grid& m_grid;
    const std::vector<WaterCell>& m_cells;
    std::vector<std::int32_t> m_members;
    double m_cell_m, m_voxel_m;
};

}  // namespace

std::vector<float> find_water_bodies(const std::vector<WaterCell>& cells, std::int32_t width, std::int32_t height, double cell_m, double voxel_m) {
    std::vector<float> out(cells.size(), kNan);
    const Grid grid{width, height};
    std::vector<bool> seen(cells.size());
    for (std::size_t start = 0; start < cells.size(); ++start) {
        // Every body holds a cell with water points: start there, so that dry voids cost nothing.
        if (seen[start] || !cells[start].open || cells[start].points == 0) continue;
        std::vector<std::int32_t> members{static_cast<std::int32_t>(start)};
        seen[start] = true;
        std::uint64_t points = 0;
        for (std::size_t head = 0; head < members.size(); ++head) {
            points += cells[static_cast<std::size_t>(members[head])].points;
            grid.neighbours(members[head], [&](std::int32_t n) {
                if (seen[static_cast<std::size_t>(n)] || !cells[static_cast<std::size_t>(n)].open) return;
                seen[static_cast<std::size_t>(n)] = true;
                members.push_back(n);
            });
        }
        if (points >= kFewestPoints) Body(grid, cells, std::move(members), cell_m, voxel_m).level(out);
    }
    return out;
}

}  // namespace terravox::voxelize
