#include "voxelserver/tools/survey/waters.hpp"

#include "voxelserver/tools/survey/hash.hpp"
#include "voxelserver/tools/survey/noise.hpp"

namespace terravox::survey {
namespace {

/// Part of the radius by which bays and capes deviate from the ellipse.
constexpr double kShoreSway = 0.16;

// Distance from the centre to the shore, for a direction of length 1. Noise over the unit circle
// closes on itself.
double shore_radius(const Lake& lake, Vec2 direction) noexcept {
    const double ex = direction.x / lake.radius_x_m;
    const double ey = direction.y / lake.radius_y_m;
    const double ellipse = 1.0 / std::sqrt(ex * ex + ey * ey);
    const double sway =
        0.75 * noise_2d(lake.seed, direction.x * 1.6 + 7.3, direction.y * 1.6 + 3.1) +
        0.35 * noise_2d(lake.seed + 1, direction.x * 4.5, direction.y * 4.5);
    return ellipse * (1.0 + kShoreSway * std::clamp(sway, -1.0, 1.0));
}

}  // namespace

double Lake::shore_distance(Vec2 p) const noexcept {
    const Vec2 from = p - centre;
    return length(from) - shore_radius(*this, unit(from));
}

Vec2 Lake::shore_point(Vec2 direction) const noexcept {
    return centre + direction * shore_radius(*this, direction);
}

double Lake::reach_m() const noexcept {
    return std::max(radius_x_m, radius_y_m) * (1.0 + kShoreSway);
}

std::vector<Vec2> Lake::shore_ring(int points) const {
    std::vector<Vec2> ring;
    ring.reserve(static_cast<std::size_t>(points));
    // Directions of equal steps along the four sides of a square, then normalised: a circle without
    // sine and cosine.
    for (int i = 0; i < points; ++i) {
        const double s = 8.0 * i / points;
        const double t = s - 2.0 * std::floor(s / 2.0) - 1.0;
        const int side = static_cast<int>(s / 2.0) % 4;
        const Vec2 square = side == 0   ? Vec2{1, t}
                            : side == 1 ? Vec2{-t, 1}
                            : side == 2 ? Vec2{-1, -t}
                                        : Vec2{t, -1};
        ring.push_back(shore_point(unit(square)));
    }
    return ring;
}

River::River(std::uint64_t seed, std::int64_t index) noexcept
    : m_seed(hash_of(seed, 0x52, index)),
      m_index(index),
      m_base_y(static_cast<double>(index) * kRiverSpacing_m - kRiverSouth_m),
      m_base_level_m(470.0 + (index == 0 ? 0.0 : Random(m_seed).range(-45.0, 45.0))) {}

double River::centre_y(double x) const noexcept {
    // Near the place the river keeps to its bed of the manual layout; farther away it swings
    // freely.
    const double freedom = m_index == 0 ? smoothstep(600.0, 2600.0, std::abs(x)) : 1.0;
    return m_base_y + lerp(15.0, 340.0, freedom) * noise_1d(m_seed, x / 950.0) +
           lerp(20.0, 30.0, freedom) * noise_1d(m_seed + 1, x / 170.0);
}

double River::level_m(double x) const noexcept {
    // 4 m a kilometre at the place, less and less far away, so that the endless river stays between
    // the hills and the sea.
    return m_base_level_m - 0.004 * x / (1.0 + std::abs(x) / 40000.0);
}

double River::half_width_m(double x) const noexcept {
    return 7.0 + 1.6 * noise_1d(m_seed + 2, x / 130.0);
}

RiverAtX River::at(double x) const noexcept {
    const double slope = (centre_y(x + 4.0) - centre_y(x - 4.0)) / 8.0;
    return {centre_y(x), 1.0 / std::sqrt(1.0 + slope * slope), level_m(x), half_width_m(x)};
}

Brook::Spot Brook::nearest(Vec2 p) const noexcept {
    Spot best;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const auto on = nearest_on_segment(p, line[i - 1].at, line[i].at);
        if (on.distance_m < best.distance_m)
            best = {on.distance_m, lerp(line[i - 1].level_m, line[i].level_m, on.along)};
    }
    return best;
}

}  // namespace terravox::survey
