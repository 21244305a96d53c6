#include "raytracer/analyse/evaluators/wall_outline.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "common/util/det_math.hpp"

namespace terravox::analyse {
namespace {

/// A cell of the disc, seen from outside of the wall.
struct Cell {
    int along = 0;  ///< to the left
    int out = 0;
    bool is_solid = false;
};
using Cells = std::vector<Cell>;

/// Lines of how many angles are tried, and which ones.
constexpr int kAngles = 61;
double angle_deg(int number) noexcept {
    constexpr double kStep_deg = 2.5;
    return (number - kAngles / 2) * kStep_deg;
}

/// How well lines part the solid cells from the others.
struct Fit {
    double wrong = 1;      ///< share of the cells on the wrong side of the best line
    double angle_deg = 0;  ///< of its normal to the left of outwards: the middle of the best ones

    /// A face belongs rather to the wall that looks more its way.
    [[nodiscard]] bool is_better_than(const Fit& other) const noexcept {
        return std::pair{wrong, std::abs(angle_deg)} <
               std::pair{other.wrong, std::abs(other.angle_deg)};
    }
};

/// Cells on the wrong side of the best line of an angle.
int wrong_at(double degrees, const Cells& cells) {
    const det::SinCos angle = det::sin_cos(degrees * det::kPi / 180);
    std::vector<std::pair<double, bool>> far;
    far.reserve(cells.size());
    int wrong = 0;
    for (const Cell& cell : cells) {
        far.emplace_back(cell.along * angle.sin + cell.out * angle.cos, cell.is_solid);
        wrong += cell.is_solid ? 1 : 0;
    }
    std::sort(far.begin(), far.end());
    int least = wrong;
    for (std::size_t i = 0; i < far.size(); ++i) {
        wrong += far[i].second ? -1 : 1;
        // Cells at one distance are on one side.
        constexpr double kSame = 1e-9;
        if (i + 1 == far.size() || far[i + 1].first > far[i].first + kSame)
            least = std::min(least, wrong);
    }
    return least;
}

Fit fit_of(const Cells& cells) {
    int least = static_cast<int>(cells.size());
    double sum_deg = 0;
    int angles = 0;
    for (int i = 0; i < kAngles; ++i) {
        const int wrong = wrong_at(angle_deg(i), cells);
        if (wrong < least) {
            least = wrong;
            sum_deg = 0;
            angles = 0;
        }
        if (wrong == least) {
            sum_deg += angle_deg(i);
            ++angles;
        }
    }
    return {static_cast<double>(least) / static_cast<double>(cells.size()), sum_deg / angles};
}

}  // namespace

core::Vec3 direction_of(core::WallSide side) noexcept {
    switch (side) {
        case core::WallSide::kNorth: return {0, 0, -1};
        case core::WallSide::kEast: return {1, 0, 0};
        case core::WallSide::kSouth: return {0, 0, 1};
        case core::WallSide::kWest: break;
    }
    return {-1, 0, 0};
}

int WallOutline::east_of(std::uint32_t place) noexcept {
    return static_cast<int>(place % kEdge) - kRadius;
}

int WallOutline::south_of(std::uint32_t place) noexcept {
    return static_cast<int>(place / kEdge) - kRadius;
}

bool WallOutline::is_near(std::uint32_t place) noexcept {
    // The disc of radius 3.3 has 37 cells, and is the same in eight directions.
    constexpr int kRadiusSquared = 10;
    const int east = east_of(place);
    const int south = south_of(place);
    return east * east + south * south <= kRadiusSquared;
}

std::uint64_t WallOutline::connected() const noexcept {
    std::uint64_t found = std::uint64_t{1} << kOfCell;
    for (std::uint64_t before = 0; before != found;) {
        before = found;
        for (std::uint32_t place = 0; place < kCells; ++place) {
            if (!is_near(place) || !has(place))
                continue;
            for (std::uint32_t other = 0; other < kCells; ++other) {
                const bool is_beside = std::abs(east_of(place) - east_of(other)) <= 1 &&
                                       std::abs(south_of(place) - south_of(other)) <= 1;
                if (is_beside && ((found >> other) & 1) != 0)
                    found |= std::uint64_t{1} << place;
            }
        }
    }
    return found;
}

core::Vec3 WallOutline::normal(core::WallSide side) const noexcept {
    const core::Vec3 outwards = direction_of(side);
    const core::Vec3 left{outwards.z, 0, -outwards.x};
    const std::uint64_t solid = connected();
    Cells disc;
    Cells left_half;
    Cells right_half;
    for (std::uint32_t place = 0; place < kCells; ++place) {
        if (!is_near(place))
            continue;
        const core::Vec3 step{static_cast<double>(east_of(place)), 0,
                              static_cast<double>(south_of(place))};
        const Cell cell{static_cast<int>(core::dot(step, left)),
                        static_cast<int>(core::dot(step, outwards)), ((solid >> place) & 1) != 0};
        disc.push_back(cell);
        if (cell.along >= 0)
            left_half.push_back(cell);
        if (cell.along <= 0)
            right_half.push_back(cell);
    }
    Fit best = fit_of(disc);
    if (best.wrong > 0) {
        const Fit halves[] = {fit_of(left_half), fit_of(right_half)};
        const Fit& half = halves[0].is_better_than(halves[1]) ? halves[0] : halves[1];
        if (half.wrong < best.wrong)
            best = half;
    }
    const det::SinCos angle = det::sin_cos(best.angle_deg * det::kPi / 180);
    return outwards * angle.cos + left * angle.sin;
}

}  // namespace terravox::analyse
