#include "raytracer/core/material/windows.hpp"

#include <cmath>
#include <string_view>

#include "raytracer/core/base/random.hpp"

namespace terravox::material {
namespace {

constexpr double kFloor_m = 3;
constexpr double kSquare_m = 1.7;
constexpr double kLargestVoxel_m = 4;
// Of 256: houses without any window, and single places without one.
constexpr std::uint32_t kBlindHouses = 20;
constexpr std::uint32_t kBlind = 16;
constexpr std::uint32_t kLit = 84;  // of 256
constexpr float kHas = (1 - kBlindHouses / 256.0f) * (1 - kBlind / 256.0f);
constexpr float kMeanLit = kLit / 256.0f * 0.7f;

// One letter a texel, the upper row first:
// space wall, l lintel, s sill, d shade on the wall, r reveal, f white frame, b brown frame, k dark
// frame, 1-3 glass from dark to bright, c curtain behind glass, g G green shutter and its slats, w
// W brown shutter, u U blue-grey shutter
using Rows = std::array<std::string_view, kTexels>;
constexpr std::array<Rows, Windows::kStyles> kDrawn = {
    Rows{"                ", "  llllllllllll  ", "  rrrrrrrrrrrr  ", "  rffffffffffr  ",
         "  rfcc3ff33cfr  ", "  rfc33ff32cfr  ", "  rf332ff322fr  ", "  rf322ff221fr  ",
         "  rf221ff211fr  ", "  rf211ff111fr  ", "  rf211ff111fr  ", "  rf111ff112fr  ",
         "  rffffffffffr  ", " ssssssssssssss ", "  dddddddddddd  ", "                "},
    Rows{"                ", "                ", "  rrrrrrrrrrrr  ", "  rffffffffffr  ",
         "  rf332ff332fr  ", "  rf322ff322fr  ", "  rf221ff221fr  ", "  rffffffffffr  ",
         "  rf222ff221fr  ", "  rf221ff211fr  ", "  rf211ff111fr  ", "  rf211ff112fr  ",
         "  rffffffffffr  ", " ssssssssssssss ", "  dddddddddddd  ", "                "},
    Rows{"                ", "                ", "  rrrrrrrrrrrr  ", "  rkkkkkkkkkkr  ",
         "  rk33333322kr  ", "  rk33333221kr  ", "  rk33332211kr  ", "  rk33322111kr  ",
         "  rk33221111kr  ", "  rk32211112kr  ", "  rk22111122kr  ", "  rk21111223kr  ",
         "  rkkkkkkkkkkr  ", "  ssssssssssss  ", "   dddddddddd   ", "                "},
    Rows{"                ", "    llllllll    ", " gggrrrrrrrrggg ", " gGgfffffffFgGg ",
         " gggfc3ff3cfggg ", " gGgf33ff32fgGg ", " gggf32ff22fggg ", " gGgf22ff21fgGg ",
         " gggffffffffggg ", " gGgf22ff21fgGg ", " gggf21ff11fggg ", " gGgf11ff11fgGg ",
         " gggffffffffggg ", " gGgssssssssgGg ", " dddddddddddddd ", "                "},
    Rows{"                ", " www        www ", " wWwrrrrrrrrwWw ", " wwwbbbbbbbbwww ",
         " wWwb33bb32bwWw ", " wwwb32bb22bwww ", " wWwb32bb21bwWw ", " wwwb22bb21bwww ",
         " wWwbbbbbbbbwWw ", " wwwb21bb11bwww ", " wWwb21bb11bwWw ", " wwwb11bb12bwww ",
         " wWwbbbbbbbbwWw ", " wwwsssssssswww ", " dddddddddddddd ", "                "},
    Rows{"                ", "    llllllll    ", " uuurrrrrrrruuu ", " uUuffffffffuUu ",
         " uuufcc33ccfuuu ", " uUufc3333cfuUu ", " uuuf333322fuuu ", " uUuffffffffuUu ",
         " uuuf322221fuuu ", " uUuf222111fuUu ", " uuuf221111fuuu ", " uUuf211112fuUu ",
         " uuuffffffffuuu ", " uUussssssssuUu ", " dddddddddddddd ", "                "},
    Rows{"                ", "   llllllllll   ", "   lrrrrrrrrl   ", "   lrbbbbbbrl   ",
         "   lb33bb32bl   ", "   lb32bb22bl   ", "   lbbbbbbbbl   ", "   lb22bb22bl   ",
         "   lb22bb21bl   ", "   lb21bb11bl   ", "   lb11bb11bl   ", "   lb11bb12bl   ",
         "   lbbbbbbbbl   ", "  ssssssssssss  ", "   dddddddddd   ", "                "},
    Rows{"                ", "                ", " rrrrrrrrrrrrrr ", " rffffffffffffr ",
         " rfcc3f333f3cfr ", " rfc33f332f22fr ", " rf332f322f21fr ", " rf322f221f11fr ",
         " rf221f211f11fr ", " rf211f111f11fr ", " rf211f111f12fr ", " rffffffffffffr ",
         " ssssssssssssss ", "  dddddddddddd  ", "                ", "                "},
};

Windows::Pane make_pane(char letter, float shade) noexcept {
    const auto own = [&](float r, float g, float b) {
        return Windows::Pane{voxel::Colour{r, g, b} * shade, 1, 0};
    };
    const auto glass = [](float r, float g, float b) { return Windows::Pane{{r, g, b}, 1, 1}; };
    switch (letter) {
        case 'l': return own(0.52f, 0.49f, 0.44f);
        case 's': return own(0.58f, 0.56f, 0.52f);
        case 'd': return {{0, 0, 0}, 0.30f, 0};
        case 'r': return {{0.02f, 0.02f, 0.02f}, 0.55f, 0};
        case 'F':
        case 'f': return own(0.72f, 0.70f, 0.66f);
        case 'b': return own(0.17f, 0.085f, 0.04f);
        case 'k': return own(0.045f, 0.048f, 0.052f);
        case '1': return glass(0.016f, 0.024f, 0.034f);
        case '2': return glass(0.028f, 0.042f, 0.058f);
        case '3': return glass(0.055f, 0.085f, 0.115f);
        case 'c': return glass(0.27f, 0.27f, 0.26f);
        case 'g': return own(0.060f, 0.135f, 0.070f);
        case 'G': return own(0.038f, 0.090f, 0.046f);
        case 'w': return own(0.155f, 0.072f, 0.032f);
        case 'W': return own(0.100f, 0.045f, 0.020f);
        case 'u': return own(0.120f, 0.165f, 0.205f);
        case 'U': return own(0.080f, 0.112f, 0.145f);
        default: return {};
    }
}

Windows::Pane blend(const Windows::Pane& a, const Windows::Pane& b, float t) noexcept {
    const float share = a.share * (1 - t) + b.share * t;
    if (!(share > 0))
        return {};
    return {(a.own * (a.share * (1 - t)) + b.own * (b.share * t)) * (1 / share), share,
            a.glass * (1 - t) + b.glass * t};
}

std::size_t place(int style, int mip, int s, int t) noexcept {
    return static_cast<std::size_t>(style) * kMipAt[kMips] + kMipAt[static_cast<std::size_t>(mip)] +
           static_cast<std::size_t>((t << (4 - mip)) + s);
}

int whole(double v) noexcept {
    return static_cast<int>(std::floor(v + 0.5));
}

// v / by, rounded down, by the reciprocal of `by`; exact: the half keeps it farther from whole
// numbers than rounding reaches.
std::int32_t divided(std::int32_t v, double reciprocal) noexcept {
    return static_cast<std::int32_t>(std::floor((static_cast<double>(v) + 0.5) * reciprocal));
}

std::uint64_t mixed(std::int32_t a, std::int32_t b, std::int32_t c, std::uint64_t seed) noexcept {
    return core::hash64((static_cast<std::uint64_t>(static_cast<std::uint32_t>(a)) |
                         static_cast<std::uint64_t>(static_cast<std::uint32_t>(b)) << 32) ^
                        (static_cast<std::uint64_t>(static_cast<std::uint32_t>(c)) + seed) *
                            0x9e3779b97f4a7c15);
}

}  // namespace

Windows::Windows() {
    m_panes.resize(std::size_t{kStyles} * kMipAt[kMips]);
    for (int style = 0; style < kStyles; ++style) {
        for (int t = 0; t < kTexels; ++t)
            for (int s = 0; s < kTexels; ++s) {
                const char letter =
                    kDrawn[static_cast<std::size_t>(style)]
                          [static_cast<std::size_t>(kTexels - 1 - t)][static_cast<std::size_t>(s)];
                m_panes[place(style, 0, s, t)] =
                    make_pane(letter, 1 + 0.05f * grain(s, t, static_cast<std::uint64_t>(style)));
            }
        for (int mip = 1, size = 8; mip < kMips; ++mip, size /= 2)
            for (int t = 0; t < size; ++t)
                for (int s = 0; s < size; ++s) {
                    const auto fine = [&](int i, int j) {
                        return pane(style, mip - 1, 2 * s + i, 2 * t + j);
                    };
                    m_panes[place(style, mip, s, t)] =
                        blend(blend(fine(0, 0), fine(1, 0), 0.5f),
                              blend(fine(0, 1), fine(1, 1), 0.5f), 0.5f);
                }
        m_mean = blend(m_mean, pane(style, kMips - 1, 0, 0), 1 / static_cast<float>(style + 1));
    }
}

const Windows::Pane& Windows::pane(int style, int mip, int s, int t) const noexcept {
    return m_panes[place(style, mip, s, t)];
}

Windows::Grid Windows::make_grid(double voxel_m) noexcept {
    Grid grid;
    const double per_m = 1 / voxel_m;
    grid.floor = std::max(1, whole(kFloor_m * per_m));
    grid.across = std::max(2, grid.floor);
    grid.edge = voxel_m >= 1 ? 1 : std::clamp(whole(kSquare_m * per_m), 1, grid.floor);
    // In a voxel of a metre the drawing is a little larger than the face: only its empty border is
    // lost.
    grid.fills = voxel_m >= 1 ? static_cast<float>(std::min(1.14, kSquare_m * per_m)) : 1.0f;
    grid.per_floor = 1.0 / grid.floor;
    grid.per_across = grid.across == grid.floor ? grid.per_floor : 0.5;
    return grid;
}

Windows::Pane Windows::found_at(const At& at, const Grid& grid, float texels,
                                float& lit) const noexcept {
    const std::int32_t window = divided(at.along, grid.per_across);
    const std::int32_t floor = divided(at.up, grid.per_floor);
    const std::int32_t in_s = at.along - window * grid.across - (grid.across - grid.edge) / 2;
    const std::int32_t in_t = at.up - floor * grid.floor - (grid.floor - grid.edge + 1) / 2;
    if (in_s < 0 || in_s >= grid.edge || in_t < 0 || in_t >= grid.edge)
        return {};
    const float per_edge = 1 / (static_cast<float>(grid.edge) * grid.fills);
    const float border = (1 - 1 / grid.fills) / 2;
    const float s = (static_cast<float>(in_s) + at.s) * per_edge + border;
    const float t = (static_cast<float>(in_t) + at.t) * per_edge + border;
    if (!(s >= 0 && s < 1 && t >= 0 && t < 1))
        return {};
    // Four windows, as many in depth, and eight floors share a style.
    const std::int32_t deep = divided(at.into, grid.per_across) >> 2;
    const std::int32_t house = window >> 2;
    const std::uint64_t of_house =
        mixed(at.along_x ? house : deep, at.along_x ? deep : house, floor >> 3, 1);
    const std::uint64_t of_window = mixed(window, at.into, floor, at.along_x ? 2 : 3);
    if ((of_house >> 8 & 255) < kBlindHouses || (of_window & 255) < kBlind)
        return {};
    if ((of_window >> 8 & 255) < kLit)
        lit = 0.4f + 0.6f * static_cast<float>(of_window >> 16 & 255) / 255;
    const int style = static_cast<int>(of_house & (kStyles - 1));
    const auto of_mip = [&](int mip) {
        const auto size = static_cast<float>(kTexels >> mip);
        return pane(style, mip, static_cast<int>(s * size), static_cast<int>(t * size));
    };
    const MipPair mips = MipPair::of(texels);
    const Pane fine = of_mip(mips.fine);
    return mips.coarse_share > 0 ? blend(fine, of_mip(mips.fine + 1), mips.coarse_share) : fine;
}

void Windows::draw(const At& at, const FacePoint& point, Texel& out) const noexcept {
    out.emission = 0;
    if (!(point.voxel_m <= kLargestVoxel_m))
        return;
    const Grid grid = make_grid(point.voxel_m);
    const float square = static_cast<float>(grid.edge) * grid.fills;
    // Where a pixel covers more than a window the wall's mean takes over.
    const float texels = static_cast<float>(point.footprint) * kTexels / square;
    const float far = point.level > 0 ? 1.0f
                      : texels > 8    ? std::min((rough_log2(texels) - 3) / 3, 1.0f)
                                      : 0.0f;
    Pane found;
    float lit = 0;
    if (far < 1)
        found = found_at(at, grid, texels, lit);
    float light = found.glass * lit;  // goes with the glass: means are means of the product
    if (far > 0) {
        const float share = square * square / static_cast<float>(grid.across * grid.floor) * kHas;
        const Pane mean = {m_mean.own, m_mean.share * share, m_mean.glass * share};
        found = blend(found, mean, far);
        light += (mean.glass * kMeanLit - light) * far;
    }
    out.own = found.own;
    out.own_share = found.share;
    out.gloss = found.glass;
    if (point.night)
        out.emission = light;
}

}  // namespace terravox::material
