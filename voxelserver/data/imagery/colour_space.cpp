#include "voxelserver/data/imagery/colour_space.hpp"

#include <array>

#include "common/util/det_math.hpp"

namespace terravox::imagery {
namespace {

/// The contributions of one channel to X/Xn, Y/Yn and Z/Zn.
struct Share {
    double x;
    double y;
    double z;
};

using Shares = std::array<std::array<Share, 256>, 3>;

Shares make_shares() noexcept {
    // Linear sRGB to XYZ; each row is divided by its sum, which is the white point.
    constexpr double kMatrix[3][3] = {{0.4124564, 0.3575761, 0.1804375},
                                      {0.2126729, 0.7151522, 0.0721750},
                                      {0.0193339, 0.1191920, 0.9503041}};
    Shares out{};
    for (std::size_t v = 0; v < 256; ++v) {
        const double s = static_cast<double>(v) / 255;
        const double linear = s <= 0.04045 ? s / 12.92 : det::pow((s + 0.055) / 1.055, 2.4);
        for (std::size_t c = 0; c < 3; ++c) {
            const auto part = [&](int row) {
                return linear * kMatrix[row][c] /
                       (kMatrix[row][0] + kMatrix[row][1] + kMatrix[row][2]);
            };
            out[c][v] = {part(0), part(1), part(2)};
        }
    }
    return out;
}

double f(double t) noexcept {
    constexpr double kEdge = 216.0 / 24389;
    constexpr double kSlope = 24389.0 / 27;
    return t > kEdge ? cube_root(t) : (kSlope * t + 16) / 116;
}

}  // namespace

Lab to_lab(voxel::Rgb8 colour) noexcept {
    static const Shares shares = make_shares();
    const Share &r = shares[0][colour.r], &g = shares[1][colour.g], &b = shares[2][colour.b];
    const double x = f(r.x + g.x + b.x);
    const double y = f(r.y + g.y + b.y);
    const double z = f(r.z + g.z + b.z);
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

}  // namespace terravox::imagery
