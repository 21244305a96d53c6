#include "raytracer/core/material/material_table.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"
#include "common/util/log.hpp"

namespace terravox::material {
namespace {

// Sine-like of period 1 with a continuous slope: parabolas. Its highest value is 1.
double swing(double turns) noexcept {
    const double x = turns - std::floor(turns + 0.5);  // [-1/2, 1/2)
    return 16 * x * (0.5 - std::fabs(x));
}

// Waves per metre along x and z, and the slope they reach. Their lengths, 0.9 to 13 m, and
// directions, about a wind from the west-south-west, have no common measure, so that the sum does
// not repeat.
constexpr int kTrains = 8;
constexpr std::array<double, kTrains> kPerX = {0.0713, 0.1319, 0.2137, 0.1873,
                                               0.3511, 0.4943, 0.5519, 0.9277};
constexpr std::array<double, kTrains> kPerZ = {-0.0291, 0.0347, -0.1423, 0.1987,
                                               -0.0529, 0.2713, -0.4177, 0.5881};
constexpr std::array<double, kTrains> kSlope = {0.0050, 0.0062, 0.0066, 0.0058,
                                                0.0072, 0.0062, 0.0058, 0.0050};
constexpr std::array<double, kTrains> kLength_m = {12.98, 7.33, 3.89, 3.66, 2.81, 1.77, 1.44, 0.91};

}  // namespace

std::array<float, 2> water_tilt(double x_m, double z_m, double footprint_m) noexcept {
    // Patches of calm and of ruffled water, some 40 to 90 m.
    const double ruffled =
        0.65 + 0.35 * swing(x_m * 0.0113 + z_m * 0.0067) * swing(z_m * 0.0171 - x_m * 0.0049 + 0.3);
    std::array<double, kTrains> slope{};
    for (std::size_t i = 0; i < kTrains; ++i) {
        // Full strength up to a third of the wave's length.
        const double shown = std::clamp(1.5 - 1.5 * footprint_m / kLength_m[i], 0.0, 1.0);
        slope[i] = swing(x_m * kPerX[i] + z_m * kPerZ[i]) * kSlope[i] * shown * kLength_m[i];
    }
    double x = 0;
    double z = 0;
    for (std::size_t i = 0; i < kTrains; ++i) {
        x += slope[i] * kPerX[i];
        z += slope[i] * kPerZ[i];
    }
    return {static_cast<float>(x * ruffled), static_cast<float>(z * ruffled)};
}

namespace {

using material::PaintedFace;
using material::PaintPoint;

/// A face as a drawing sees it: s along the wall or east, t up or south.
struct OnFace {
    std::int32_t voxel_s;
    std::int32_t voxel_t;
    std::int32_t into;
    float s;
    float t;
};

OnFace on_face(const FacePoint& at) noexcept {
    const int axis = core::to_axis(at.face);
    const auto u = static_cast<float>(at.u);
    const auto v = static_cast<float>(at.v);
    return {axis == 0 ? at.voxel.z : at.voxel.x, axis == 1 ? at.voxel.z : at.voxel.y,
            at.voxel[axis], axis == 2 ? u : v, axis == 2 ? v : u};
}

std::uint64_t scrambled(std::int32_t a, std::int32_t b, std::uint32_t c) noexcept {
    std::uint64_t h = static_cast<std::uint32_t>(a) * 0x9e3779b97f4a7c15u ^
                      static_cast<std::uint32_t>(b) * 0xc2b2ae3d27d4eb4fu;
    h ^= c * std::uint64_t{0x165667b19e3779f9};
    h = (h ^ h >> 29) * 0xbf58476d1ce4e5b9u;
    return h ^ h >> 32;
}

// log2 of the voxels that a drawing of about a metre spans.
int span_shift(double voxel_m) noexcept {
    return voxel_m >= 0.7 ? 0 : voxel_m >= 0.35 ? 1 : voxel_m >= 0.17 ? 2 : voxel_m >= 0.08 ? 3 : 4;
}

// The turn that lets t run up a roof, from the solid voxels around the one above: bits as in Seen.
// kNoSlope: no slope is known.
constexpr std::uint8_t kNoSlope = 8;
constexpr std::array<std::uint8_t, 256> kSlopeTurn = [] {
    std::array<std::uint8_t, 256> out{};
    for (int around = 0; around < 256; ++around) {
        int east = 0;
        int south = 0;
        for (int bit = 0; bit < 8; ++bit) {
            if ((around >> bit & 1) == 0)
                continue;
            const int place = bit < 4 ? bit : bit + 1;
            south += place / 3 - 1;
            east += place % 3 - 1;
        }
        const bool along_z = south * south >= east * east;
        const int turn = south == 0 && east == 0 ? int{kNoSlope}
                         : along_z               ? (south > 0 ? 0 : 2)
                                                 : 4 | (east > 0 ? 0 : 2);
        out[static_cast<std::size_t>(around)] = static_cast<std::uint8_t>(turn);
    }
    return out;
}();

PaintPoint paint_point(const PaintedFace& face, const FacePoint& at, OnFace on) noexcept {
    PaintPoint out;
    const int shift = face.metric ? span_shift(at.voxel_m) : 0;
    if (shift > 0) {
        const std::int32_t within = (1 << shift) - 1;
        const float size = 1.0f / static_cast<float>(1 << shift);
        on.s = (static_cast<float>(on.voxel_s & within) + on.s) * size;
        on.t = (static_cast<float>(on.voxel_t & within) + on.t) * size;
        on.voxel_s >>= shift;
        on.voxel_t >>= shift;
        on.into >>= shift;
    }
    out.s = on.s;
    out.t = on.t;
    out.mips = material::MipPair::of(static_cast<float>(at.footprint) * material::kTexels /
                                     static_cast<float>(1 << shift));
    const std::uint64_t hash =
        scrambled(on.voxel_s, on.voxel_t,
                  static_cast<std::uint32_t>(on.into) * 8 + static_cast<std::uint32_t>(at.face));
    const auto pick = [&](std::uint32_t count) {
        return static_cast<std::uint32_t>((hash & 0xffff) * count >> 16);
    };
    out.variant = pick(face.variants);
    out.turn = static_cast<std::uint32_t>(hash >> 20) & static_cast<std::uint32_t>(face.turn);
    if (face.turn == material::Turn::kSlope) {
        const std::uint32_t turn = kSlopeTurn[at.around];
        const std::uint32_t half = face.variants / 2;
        out.turn = (out.turn & 1) | (turn & 6);
        out.variant = pick(half) + (turn == kNoSlope ? half : 0);
    }
    if (face.layered) {
        const auto layout =
            static_cast<std::uint32_t>(scrambled(on.voxel_t, 0, 0) >> 7) % material::kLayouts;
        out.variant = pick(face.variants / material::kLayouts) * material::kLayouts + layout;
    }
    return out;
}

}  // namespace

material::MaterialAppearances MaterialTable::checked(const std::filesystem::path& file) {
    const material::MaterialFile read = material::read_materials(file);
    if (!read.missing.empty()) {
        std::string names;
        for (const std::string& name : read.missing)
            names += (names.empty() ? "" : ", ") + name;
        util::log_warn("the materials {} lack {}: shown in the colour of unknown", file.string(),
                       names);
    }
    return read.appearances;
}

MaterialTable::MaterialTable(const material::MaterialAppearances& appearances) {
    const auto textures = material::textures();
    for (std::size_t i = 0; i < appearances.size(); ++i) {
        Entry& entry = m_entries[i];
        entry.appearance = appearances[i];
        const material::Texture& texture =
            textures[static_cast<std::size_t>(entry.appearance.texture) % textures.size()];
        // The top first: it may have more variants than a side of the same drawing, which then
        // finds them there.
        entry.faces[2] = m_pool.add(texture.top);
        entry.faces[0] = m_pool.add(texture.side);
        entry.faces[1] = m_pool.add(texture.bottom);
        entry.windows = texture.windows;
        entry.waves = texture.waves;
        if (texture.own != voxel::Material::kAir)
            entry.own = appearances[static_cast<std::size_t>(texture.own)].colour;
    }
}

Texel MaterialTable::texel(voxel::Material material, const FacePoint& at) const noexcept {
    const Entry& entry = m_entries[to_number(material)];
    const PaintedFace& face = entry.faces[find_side(at.face)];
    Texel out;
    if (face.variants != 0) {
        const OnFace on = on_face(at);
        PaintPoint point;
        if (at.level == 0)
            point = paint_point(face, at, on);
        else
            point.mips.fine = material::kMips - 1;
        m_pool.look_up(face, point, out);
        out.own = out.own * entry.own;
        if (at.level > 0 && face.has_holes) {
            float through = 1 - out.opacity;
            for (int level = std::min(at.level, 5); level > 0; --level)
                through *= through;
            out.opacity = 1 - through;
        }
        if (entry.windows && core::to_axis(at.face) != 1)
            m_windows.draw(
                {on.voxel_s, on.voxel_t, on.into, on.s, on.t, core::to_axis(at.face) == 2}, at,
                out);
    }
    if (entry.waves && at.face == core::Face::kTop) {
        const double size_m = at.voxel_m * det::exp2_int(at.level);
        out.tilt = material::water_tilt((at.voxel.x + at.v) * size_m, (at.voxel.z + at.u) * size_m,
                                        at.footprint * at.voxel_m);
    }
    return out;
}

}  // namespace terravox::material
