#include "voxelserver/data/water/shore.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace terravox::water {
namespace {

constexpr double kSideLow = 0.2;  // quantile of the heights on a side that counts as its low shore
constexpr std::size_t kMinCells = 4;

// Levels of the low shore on the four sides of the middle, voxels; sides without a cell are
// omitted.
std::vector<float> low_sides(const Shore& shore) {
    double x = 0;
    double z = 0;
    for (const Shore::Cell& c : shore.ground) {
        x += c.place.x;
        z += c.place.z;
    }
    x /= static_cast<double>(shore.ground.size());
    z /= static_cast<double>(shore.ground.size());
    std::array<std::vector<float>, 4> sides;
    for (const Shore::Cell& c : shore.ground) {
        const double dx = c.place.x - x;
        const double dz = c.place.z - z;
        const int side =
            std::abs(dx) > std::abs(dz) ? (dx < 0 ? kWest : kEast) : (dz < 0 ? kNorth : kSouth);
        sides[static_cast<std::size_t>(side)].push_back(c.ground);
    }
    std::vector<float> out;
    for (auto& side : sides)
        if (!side.empty())
            out.push_back(quantile(side, kSideLow));
    return out;
}

}  // namespace

std::vector<float> Shore::heights() const {
    std::vector<float> out;
    for (const Cell& c : ground)
        out.push_back(c.ground);
    return out;
}

Shore shore_of(const Candidates& candidates, const Adjacency& adjacency,
               const std::vector<std::int32_t>& members, const std::vector<char>& chosen) {
    constexpr std::array<CellPlace, 4> kSteps{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    std::vector<CellPlace> ring;
    for (const std::int32_t i : members)
        for (std::size_t side = 0; side < 4; ++side) {
            const std::int32_t n = adjacency.around(i)[side];
            if (n != Adjacency::kNone && chosen[static_cast<std::size_t>(n)] != 0)
                continue;
            const CellPlace here = candidates.places()[static_cast<std::size_t>(i)];
            ring.push_back({here.x + kSteps[side].x, here.z + kSteps[side].z});
        }
    std::sort(ring.begin(), ring.end(),
              [](CellPlace a, CellPlace b) { return a.z != b.z ? a.z < b.z : a.x < b.x; });
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    Shore out;
    for (const CellPlace place : ring) {
        const WaterCell* cell = candidates.find(place);
        if (!cell)
            continue;
        if (!cell->covered)
            out.at_survey_edge = true;
        else if (cell->ground_points > 0 && std::isfinite(cell->ground))
            out.ground.push_back({place, cell->ground});
        else
            ++out.other;
    }
    return out;
}

bool is_level_shore(const Shore& shore, const Evidence& evidence, double voxel_m) {
    const std::size_t count = shore.ground.size();
    if (count < kMinCells ||
        static_cast<double>(count) <
            evidence.ground_share_of_shore * static_cast<double>(count + shore.other))
        return false;
    std::vector<float> heights = shore.heights();
    const double low_half =
        static_cast<double>(quantile(heights, 0.45)) - static_cast<double>(quantile(heights, 0.05));
    if (!(low_half * voxel_m < evidence.flat_shore_m))
        return false;
    const std::vector<float> sides = low_sides(shore);
    const auto [low, high] = std::minmax_element(sides.begin(), sides.end());
    return (static_cast<double>(*high) - static_cast<double>(*low)) * voxel_m <
           evidence.flat_shore_m;
}

}  // namespace terravox::water
