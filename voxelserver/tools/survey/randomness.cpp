#include "voxelserver/tools/survey/randomness.hpp"

#include <cmath>

namespace terravox::survey {
namespace {

std::uint32_t lattice_hash(std::uint64_t seed, std::int64_t ix, std::int64_t iy) noexcept {
    std::uint32_t h = static_cast<std::uint32_t>(ix) * 0x8DA6B343U ^
                      static_cast<std::uint32_t>(iy) * 0xD8163841U ^
                      static_cast<std::uint32_t>(seed) ^
                      static_cast<std::uint32_t>(seed >> 32) * 0xCB1AB31FU;
    h = (h ^ (h >> 15)) * 0x2C1B3C6DU;
    h = (h ^ (h >> 12)) * 0x297A2D39U;
    return h ^ (h >> 15);
}

double fade(double t) noexcept {
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

// Eight directions, a sixteenth of a turn off the axes so that no ridge follows the lattice.
double slope_at(std::uint32_t h, double dx, double dy) noexcept {
    constexpr double kLong = 0.9238795325112867;
    constexpr double kShort = 0.3826834323650898;
    const double x = (h & 1U) != 0 ? dx : -dx;
    const double y = (h & 2U) != 0 ? dy : -dy;
    return (h & 4U) != 0 ? kLong * x + kShort * y : kShort * x + kLong * y;
}

}  // namespace

double noise_1d(std::uint64_t seed, double x) noexcept {
    const double cell = std::floor(x);
    const auto ix = static_cast<std::int64_t>(cell);
    const auto value = [&](std::int64_t i) {
        return static_cast<double>(lattice_hash(seed, i, 0)) * (2.0 / 4294967296.0) - 1.0;
    };
    const double a = value(ix);
    const double b = value(ix + 1);
    return a + (b - a) * fade(x - cell);
}

double noise_2d(std::uint64_t seed, double x, double y) noexcept {
    const double cell_x = std::floor(x);
    const double cell_y = std::floor(y);
    const auto ix = static_cast<std::int64_t>(cell_x);
    const auto iy = static_cast<std::int64_t>(cell_y);
    const double fx = x - cell_x;
    const double fy = y - cell_y;
    const double u = fade(fx);
    const double v = fade(fy);
    const double a = slope_at(lattice_hash(seed, ix, iy), fx, fy);
    const double b = slope_at(lattice_hash(seed, ix + 1, iy), fx - 1.0, fy);
    const double c = slope_at(lattice_hash(seed, ix, iy + 1), fx, fy - 1.0);
    const double d = slope_at(lattice_hash(seed, ix + 1, iy + 1), fx - 1.0, fy - 1.0);
    const double low = a + (b - a) * u;
    const double high = c + (d - c) * u;
    return (low + (high - low) * v) * 1.5;
}

double fractal_2d(std::uint64_t seed, double x, double y, int octaves) noexcept {
    double sum = 0;
    double height = 0.5;
    for (int i = 0; i < octaves; ++i) {
        sum +=
            height * noise_2d(seed + static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ULL, x, y);
        x *= 2.03125;
        y *= 2.03125;
        height *= 0.5;
    }
    return sum;
}

}  // namespace terravox::survey
