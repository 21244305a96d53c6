#include "voxelserver/make/worlds/procedural/noise.hpp"

#include <array>
#include <cmath>

namespace terravox::procedural {
namespace {

// Of a whole number.
std::uint64_t to_bits(double whole) noexcept {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(whole));
}

// Which corners contribute cannot be predicted, so this has no branches.
double positive_part(double v) noexcept {
    return 0.5 * (v + std::abs(v));
}

// Only the highest bits are used: those depend on all of the sum.
std::uint64_t scrambled(std::uint64_t sum) noexcept {
    sum = (sum ^ sum >> 32) * 0xD6E8FEB86659FD93ULL;
    return (sum ^ sum >> 32) * 0xD6E8FEB86659FD93ULL;
}
constexpr std::uint64_t kAcrossX = 0x9E3779B97F4A7C15ULL;
constexpr std::uint64_t kAcrossY = 0xC2B2AE3D27D4EB4FULL;
constexpr std::uint64_t kAcrossZ = 0x165667B19E3779F9ULL;

struct Direction {
    double x;
    double y;
};
// Sixteen of unit length, none along an axis.
constexpr double kA = 0.98078528040323044913;
constexpr double kB = 0.19509032201612826785;
constexpr double kC = 0.83146961230254523708;
constexpr double kD = 0.55557023301960222474;
constexpr std::array<Direction, 16> kDirections{{{kA, kB},
                                                 {kC, kD},
                                                 {kD, kC},
                                                 {kB, kA},
                                                 {-kB, kA},
                                                 {-kD, kC},
                                                 {-kC, kD},
                                                 {-kA, kB},
                                                 {-kA, -kB},
                                                 {-kC, -kD},
                                                 {-kD, -kC},
                                                 {-kB, -kA},
                                                 {kB, -kA},
                                                 {kD, -kC},
                                                 {kC, -kD},
                                                 {kA, -kB}}};

// The contribution of a corner: zero from where another triangle begins.
double corner(std::uint64_t hash, double x, double y) noexcept {
    double t = positive_part(0.5 - x * x - y * y);
    t *= t;
    const Direction& d = kDirections[hash >> 60];
    return t * t * (d.x * x + d.y * y);
}

// Directions to the middles of a cube's edges, and four of them again.
constexpr std::array<std::array<double, 3>, 16> kEdges{{{1, 1, 0},
                                                        {-1, 1, 0},
                                                        {1, -1, 0},
                                                        {-1, -1, 0},
                                                        {1, 0, 1},
                                                        {-1, 0, 1},
                                                        {1, 0, -1},
                                                        {-1, 0, -1},
                                                        {0, 1, 1},
                                                        {0, -1, 1},
                                                        {0, 1, -1},
                                                        {0, -1, -1},
                                                        {1, 1, 0},
                                                        {-1, 1, 0},
                                                        {0, -1, 1},
                                                        {0, -1, -1}}};

double corner(std::uint64_t hash, double x, double y, double z) noexcept {
    double t = positive_part(0.5 - x * x - y * y - z * z);
    t *= t;
    const auto& d = kEdges[hash >> 60];
    return t * t * (d[0] * x + d[1] * y + d[2] * z);
}

}  // namespace

double simplex(std::uint64_t seed, double x, double y) noexcept {
    constexpr double kSkew = 0.36602540378443864676,
                     kUnskew = 0.21132486540518711775;  // (sqrt 3 - 1) / 2, (3 - sqrt 3) / 6
    constexpr double kScale = 99.0;                     // to [-1, 1]; verified by tests
    const double s = (x + y) * kSkew;
    const double i = std::floor(x + s);
    const double j = std::floor(y + s);
    const double back = (i + j) * kUnskew;
    const double x0 = x - (i - back);
    const double y0 = y - (j - back);
    const bool right = x0 > y0;
    const auto step_x = static_cast<double>(right);
    const double x1 = x0 - step_x + kUnskew;
    const double y1 = y0 - (1 - step_x) + kUnskew;
    const double x2 = x0 - 1 + 2 * kUnskew;
    const double y2 = y0 - 1 + 2 * kUnskew;
    const std::uint64_t at = seed + to_bits(i) * kAcrossX + to_bits(j) * kAcrossY;
    const std::uint64_t step = kAcrossY + static_cast<std::uint64_t>(right) * (kAcrossX - kAcrossY);
    return kScale * (corner(scrambled(at), x0, y0) + corner(scrambled(at + step), x1, y1) +
                     corner(scrambled(at + kAcrossX + kAcrossY), x2, y2));
}

double simplex(std::uint64_t seed, double x, double y, double z) noexcept {
    constexpr double kSkew = 1.0 / 3;
    constexpr double kUnskew = 1.0 / 6;
    constexpr double kScale = 75.0;  // to [-1, 1]; verified by tests
    const double s = (x + y + z) * kSkew;
    const double i = std::floor(x + s);
    const double j = std::floor(y + s);
    const double k = std::floor(z + s);
    const double back = (i + j + k) * kUnskew;
    const double x0 = x - (i - back);
    const double y0 = y - (j - back);
    const double z0 = z - (k - back);
    const std::uint64_t at =
        seed + to_bits(i) * kAcrossX + to_bits(j) * kAcrossY + to_bits(k) * kAcrossZ;
    // Along the largest coordinate first, then along the second: by rank, without branches for the
    // six orders.
    const int rank_x = (x0 >= y0) + (x0 >= z0);
    const int rank_y = (y0 > x0) + (y0 >= z0);
    const int rank_z = (z0 > x0) + (z0 > y0);
    double sum = corner(scrambled(at), x0, y0, z0);
    for (int step = 1; step <= 2; ++step) {
        const int dx = rank_x >= 3 - step;
        const int dy = rank_y >= 3 - step;
        const int dz = rank_z >= 3 - step;
        const double moved = step * kUnskew;
        sum += corner(scrambled(at + static_cast<std::uint64_t>(dx) * kAcrossX +
                                static_cast<std::uint64_t>(dy) * kAcrossY +
                                static_cast<std::uint64_t>(dz) * kAcrossZ),
                      x0 - dx + moved, y0 - dy + moved, z0 - dz + moved);
    }
    sum += corner(scrambled(at + kAcrossX + kAcrossY + kAcrossZ), x0 - 1 + 3 * kUnskew,
                  y0 - 1 + 3 * kUnskew, z0 - 1 + 3 * kUnskew);
    return kScale * sum;
}

}  // namespace terravox::procedural
