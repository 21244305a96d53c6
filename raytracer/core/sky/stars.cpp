#include "raytracer/core/sky/stars.hpp"

#include <algorithm>
#include <cmath>

#include "raytracer/core/base/random.hpp"

namespace terravox::sky {
namespace {

constexpr int kCells = 24;          // along an edge of each face of the cube around the observer
constexpr double kShare = 0.4;      // of the cells that hold a star
constexpr double kRadius = 0.0011;  // radians
constexpr std::uint64_t kSeed = 0x5741525354415253;

struct Place {
    int face;
    double u, v;  // [-1, 1]
};

Place place_of(core::Vec3 d) noexcept {
    const double ax = std::fabs(d.x);
    const double ay = std::fabs(d.y);
    const double az = std::fabs(d.z);
    if (ay >= ax && ay >= az)
        return {d.y > 0 ? 0 : 1, d.x / ay, d.z / ay};
    if (ax >= az)
        return {d.x > 0 ? 2 : 3, d.y / ax, d.z / ax};
    return {d.z > 0 ? 4 : 5, d.x / az, d.y / az};
}

core::Vec3 direction_of(const Place& p) noexcept {
    const double s = p.face % 2 == 0 ? 1 : -1;
    return core::normalized(p.face < 2   ? core::Vec3{p.u, s, p.v}
                            : p.face < 4 ? core::Vec3{s, p.u, p.v}
                                         : core::Vec3{p.u, p.v, s});
}

int cell_of(double u) noexcept {
    return u > -1 ? std::min(static_cast<int>((std::min(u, 1.0) + 1) / 2 * kCells), kCells - 1) : 0;
}

}  // namespace

voxel::Colour starlight(core::Vec3 d) noexcept {
    const Place at = place_of(d);
    const int i = cell_of(at.u);
    const int j = cell_of(at.v);
    std::uint64_t hash =
        core::hash64(kSeed, static_cast<std::uint64_t>((at.face * kCells + i) * kCells + j));
    const auto next = [&] { return core::unit_from(hash = core::hash64(hash)); };
    if (next() >= kShare)
        return {};
    // A star keeps such a distance from the edge of its cell that it never extends into another
    // cell.
    constexpr double kInside = 0.9;
    const auto inside = [&](int cell) {
        return (cell + 0.5 + kInside * (next() - 0.5)) * 2 / kCells - 1;
    };
    const double u = inside(i);
    const double v = inside(j);
    const core::Vec3 apart = d - direction_of({at.face, u, v});
    const double r2 = core::dot(apart, apart) / (kRadius * kRadius);
    if (!(r2 < 1))
        return {};
    // Ten stars of half the brightness for each one; the few bright ones are what the eye finds
    // patterns in.
    const double rank = 1 - next();
    const double brightness = std::min(12 / std::sqrt(rank) - 8, 160.0);
    const double warmth = next();
    const double falloff = (1 - r2) * (1 - r2);
    const voxel::Colour tint = voxel::mix({0.72f, 0.84f, 1.25f}, {1.25f, 0.98f, 0.72f},
                                          static_cast<float>(warmth * warmth));
    return tint * static_cast<float>(brightness * falloff);
}

}  // namespace terravox::sky
