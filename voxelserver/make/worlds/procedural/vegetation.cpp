#include "voxelserver/make/worlds/procedural/vegetation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/procedural/noise.hpp"

namespace terravox::procedural {
namespace {

// Sizes of one plant, from its hash.
struct Size {
    int trunk = 0;             // voxels of bare or hidden stem
    int top = 0;               // one past its highest leaves
    int radius = 0;            // of the crown
    int middle = 0, half = 1;  // of a round crown: height of its middle, half its height
};

int pick(std::uint64_t hash, int part, int from, int count) noexcept {
    return from + static_cast<int>(hash >> (8 * part) & 0xFF) * count / 256;
}

Size measure_size(const Tree& t) noexcept {
    const std::uint64_t h = t.hash;
    Size s;
    switch (t.kind) {
        case TreeKind::kOak: {
            const bool big = pick(h, 0, 0, 7) == 0;
            s.trunk = pick(h, 1, 3, 3) + (big ? 2 : 0);
            s.radius = big ? 4 : pick(h, 2, 2, 2);
            s.half = big ? 3 : pick(h, 3, 2, 2);
            s.middle = s.trunk + s.half - 1;
            break;
        }
        case TreeKind::kBirch:
            s.trunk = pick(h, 1, 4, 3);
            s.radius = 2;
            s.half = pick(h, 3, 2, 2);
            s.middle = s.trunk + s.half - 1;
            break;
        case TreeKind::kConifer:
            s.top = pick(h, 1, 7, 8);
            s.radius = s.top > 10 ? 3 : 2;
            s.trunk = s.top - 3;
            return s;
        case TreeKind::kPalm:
            s.trunk = pick(h, 1, 5, 4);
            s.radius = 3;
            s.top = s.trunk + 1;
            return s;
        case TreeKind::kAcacia:
            s.trunk = pick(h, 1, 4, 3);
            s.radius = pick(h, 2, 3, 2);
            s.top = s.trunk + 2;
            return s;
        case TreeKind::kCactus:
            s.trunk = s.top = pick(h, 1, 2, 3);
            s.radius = s.trunk > 3 ? 1 : 0;
            return s;
        case TreeKind::kBush:
            s.radius = 1;
            s.top = pick(h, 1, 1, 2);
            s.trunk = 0;
            return s;
    }
    s.top = s.middle + s.half + 1;
    return s;
}

// Ragged edges: a number in [0, 64) for each voxel of each plant.
int rough(const Tree& t, int dx, int dy, int dz) noexcept {
    return static_cast<int>(mix(t.hash + static_cast<std::uint64_t>(dx * 4096 + dy * 64 + dz)) >>
                            58);
}

bool leaf_at(const Tree& t, const Size& s, int dx, int dy, int dz) noexcept {
    const int d2 = dx * dx + dz * dz;
    const int far = std::max(std::abs(dx), std::abs(dz));
    switch (t.kind) {
        case TreeKind::kOak:
        case TreeKind::kBirch: {
            const int up = dy - s.middle;
            if (std::abs(up) > s.half)
                return false;
            // An ellipsoid half a voxel larger than its axes, in hundredths.
            const int q = 400 * d2 / ((2 * s.radius + 1) * (2 * s.radius + 1)) +
                          400 * up * up / ((2 * s.half + 1) * (2 * s.half + 1));
            return q < 62 || (q < 110 && q < 62 + rough(t, dx, dy, dz));
        }
        case TreeKind::kConifer: {
            const int down = s.top - 1 - dy;
            if (down < 0 || dy < 2)
                return false;
            const int wide = std::min(down / 3 + 1, s.radius);
            const int r = down == 0 ? 0 : down % 3 == 0 && wide > 1 ? wide - 1 : wide;
            return d2 <= r * r + (r > 1 ? 1 : 0) &&
                   (d2 < r * r || down < 2 || rough(t, dx, dy, dz) > 9);
        }
        case TreeKind::kPalm: {
            if (far > s.radius || (dx != 0 && dz != 0 && std::abs(dx) != std::abs(dz)))
                return false;
            const int reach = dx != 0 && dz != 0 ? 2 : 3;
            return far <= reach && dy == s.trunk - (far == reach ? 1 : 0);
        }
        case TreeKind::kAcacia: {
            const int r = dy == s.trunk ? s.radius : dy == s.trunk + 1 ? s.radius - 1 : 0;
            return r > 0 && d2 <= r * r + 1 && (d2 < r * r - 1 || rough(t, dx, dy, dz) > 14);
        }
        case TreeKind::kCactus: return false;
        case TreeKind::kBush:
            return dy >= 0 && dy < s.top && d2 <= 2 - dy && (d2 == 0 || rough(t, dx, dy, dz) > 10);
    }
    return false;
}

bool trunk_at(const Tree& t, const Size& s, int dx, int dy, int dz) noexcept {
    if (dx == 0 && dz == 0)
        return dy < s.trunk;
    // The arms of a cactus: to two sides, then up.
    if (t.kind != TreeKind::kCactus || s.trunk < 4)
        return false;
    const bool along_x = (t.hash & 1) != 0;
    const int along = along_x ? dx : dz;
    const int across = along_x ? dz : dx;
    return across == 0 && std::abs(along) == 1 && dy >= (along > 0 ? 1 : 2) && dy < 4;
}

}  // namespace

int tree_reach(const Tree& tree) noexcept {
    return measure_size(tree).radius;
}

TreeRuns tree_runs(const Tree& tree, int dx, int dz) noexcept {
    const Size size = measure_size(tree);
    TreeRuns out;
    const int top = std::max(size.top, size.trunk);
    for (int dy = 0; dy < top; ++dy) {
        const bool trunk = trunk_at(tree, size, dx, dy, dz);
        if (!trunk && !leaf_at(tree, size, dx, dy, dz))
            continue;
        TreeRun* last =
            out.count > 0 ? &out.runs[static_cast<std::size_t>(out.count - 1)] : nullptr;
        if (last != nullptr && last->y1 == dy && last->trunk == trunk)
            last->y1 = dy + 1;
        else if (out.count < static_cast<int>(out.runs.size()))
            out.runs[static_cast<std::size_t>(out.count++)] = {dy, dy + 1, trunk};
    }
    return out;
}

using voxel::Material;
using voxel::Rgb8;
using voxel::VoxelAttr;

namespace {

VoxelAttr coloured(Material material, Rgb8 colour) noexcept {
    VoxelAttr out;
    out.material = material;
    out.flags = VoxelAttr::kHasColour;
    out.colour = colour;
    return out;
}

}  // namespace

Vegetation::Vegetation(const Terrain& terrain)
    : m_on(terrain.settings().trees),
      m_cell_seed(make_seed(terrain.settings().seed, 201)),
      m_grove_seed(make_seed(terrain.settings().seed, 202)),
      m_water(terrain.settings().water_level),
      m_world(terrain.settings().world_height) {}

Vegetation::Spot Vegetation::spot(std::int32_t cell_x, std::int32_t cell_z) const noexcept {
    const std::uint64_t h = place_hash(m_cell_seed, cell_x, cell_z);
    return {cell_x * kCell + static_cast<std::int32_t>((h & 0xFFFF) * kCell >> 16),
            cell_z * kCell + static_cast<std::int32_t>((h >> 16 & 0xFFFF) * kCell >> 16), h};
}

Vegetation::Growth Vegetation::growth(const Spot& spot, const Place& p,
                                      const Skin& skin) const noexcept {
    const double above = p.height - m_water;
    if (above < 0.5 || above > kHighest * m_world - 1 || p.slope > 1.1)
        return {};
    const double t = p.temperature;
    const double u = to_unit(spot.hash, 3) - 0.5;
    if (skin.material == Material::kSand) {
        if (above < 5 && t > 0.55)
            return {0.07, TreeKind::kPalm};
        if (p.moisture < 0.45 && t > 0.6)
            return {0.022, u < 0.3 ? TreeKind::kCactus : TreeKind::kBush};
        return {};
    }
    if (skin.material == Material::kGround)
        return {t > 0.16 ? 0.03 : 0, t < 0.4 ? TreeKind::kConifer : TreeKind::kBush};
    const bool soft = skin.material == Material::kGrass || skin.material == Material::kSoil ||
                      skin.material == Material::kSnow;
    if (!soft)
        return {};
    const double grove =
        p.moisture + 0.13 * simplex(m_grove_seed, spot.x * (1.0 / 70), spot.z * (1.0 / 70));
    const double steep = smooth_step(1.1, 0.7, p.slope);
    if (t + 0.06 * u < 0.4) {
        const double line = smooth_step(0.5, 0.32, above / m_world) * smooth_step(-0.1, 0.05, t) *
                            (skin.material == Material::kSnow ? 0.4 : 1);
        return {(0.02 + 0.72 * smooth_step(0.34, 0.56, grove)) * line * steep, TreeKind::kConifer};
    }
    if (t > 0.6 && p.moisture + 0.05 * u < 0.52)
        return {(0.05 + 0.1 * smooth_step(0.4, 0.6, grove)) * steep,
                u < 0.15 ? TreeKind::kAcacia : TreeKind::kBush};
    const double wood = 0.03 + 0.72 * smooth_step(0.44, 0.6, grove);
    const bool birch =
        simplex(m_grove_seed + 1, spot.x * (1.0 / 120), spot.z * (1.0 / 120)) + u > 0.45;
    return {wood * steep, u < -0.42 ? TreeKind::kBush : birch ? TreeKind::kBirch : TreeKind::kOak};
}

Tree Vegetation::dressed(const Spot& spot, TreeKind kind, const Place& p) const noexcept {
    Tree out;
    out.x = spot.x;
    out.z = spot.z;
    out.kind = kind;
    out.hash = mix(spot.hash);
    const double own = to_unit(out.hash, 4);
    const double wet = smooth_step(0.4, 0.75, p.moisture);
    Rgb8 trunk = rgb(0x5b4632);
    Rgb8 leaves{};
    switch (kind) {
        case TreeKind::kOak:
            leaves = mixed(mixed(rgb(0x6f8a37), rgb(0x3f7a2c), wet), rgb(0x36602a), own * 0.8);
            if (p.temperature < 0.5 && to_unit(out.hash, 2) < 0.05)
                leaves = mixed(rgb(0xb9822e), rgb(0xa3592a), own);
            break;
        case TreeKind::kBirch:
            leaves = mixed(rgb(0x86a845), rgb(0x6f9440), own);
            trunk = rgb(0xd6d2c6);
            break;
        case TreeKind::kConifer:
            leaves = mixed(rgb(0x35603c), rgb(0x274d38), own);
            trunk = rgb(0x4a3826);
            leaves = mixed(leaves, rgb(0xdfe8ea),
                           0.5 * smooth_step(0.23, 0.17, p.temperature));  // under snow
            break;
        case TreeKind::kPalm:
            leaves = mixed(rgb(0x74a03c), rgb(0x5d8c34), own);
            trunk = rgb(0x8a6f4c);
            break;
        case TreeKind::kAcacia:
            leaves = mixed(rgb(0x8b9a42), rgb(0x72863a), own);
            trunk = rgb(0x6f5a48);
            break;
        case TreeKind::kCactus: trunk = mixed(rgb(0x4f7f3c), rgb(0x5f8c48), own); break;
        case TreeKind::kBush:
            leaves = mixed(Surface::grass_colour(p), rgb(0x4f6a30), 0.3 + 0.4 * own);
            break;
    }
    out.trunk = coloured(Material::kTrunk, trunk);
    out.leaves = coloured(
        kind == TreeKind::kBush ? Material::kMediumVegetation : Material::kHighVegetation, leaves);
    return out;
}

std::optional<Tree> Vegetation::tree(const Spot& spot, const Place& place,
                                     const Skin& skin) const noexcept {
    if (!possible(spot))
        return std::nullopt;
    const Growth grown = growth(spot, place, skin);
    if (!(unit_of_chance(spot) < grown.density))
        return std::nullopt;
    Tree out = dressed(spot, grown.kind, place);
    out.base = static_cast<std::int32_t>(std::floor(place.height + 0.5));
    return out;
}

std::optional<VoxelAttr> Vegetation::canopy(std::int32_t x, std::int32_t z, const Place& place,
                                            const Skin& skin) const noexcept {
    if (!m_on)
        return std::nullopt;
    const std::int32_t cell_x = voxel::floor_div(x, kCell);
    const std::int32_t cell_z = voxel::floor_div(z, kCell);
    for (std::int32_t cz = cell_z - 1; cz <= cell_z + 1; ++cz)
        for (std::int32_t cx = cell_x - 1; cx <= cell_x + 1; ++cx) {
            const Spot at = spot(cx, cz);
            if (!possible(at))
                continue;
            const std::optional<Tree> found = tree(at, place, skin);
            if (!found)
                continue;
            const int dx = x - found->x;
            const int dz = z - found->z;
            const int reach = tree_reach(*found);
            if (dx < -reach || dx > reach || dz < -reach || dz > reach)
                continue;
            const TreeRuns runs = tree_runs(*found, dx, dz);
            if (runs.count > 0)
                return runs.runs[static_cast<std::size_t>(runs.count - 1)].trunk ? found->trunk
                                                                                 : found->leaves;
        }
    return std::nullopt;
}

std::optional<VoxelAttr> Vegetation::tuft(const Place& p, const Skin& skin) const noexcept {
    if (!m_on || skin.material != Material::kGrass || p.height - m_water < 0.5 ||
        p.height - m_water > kHighest * m_world)
        return std::nullopt;
    const double u = to_unit(p.hash, 1);
    const double meadow = smooth_step(0.25, 0.8, p.patch) * smooth_step(0.25, 0.4, p.temperature);
    const double share = 0.02 + 0.12 * meadow;
    if (u >= share)
        return std::nullopt;
    static constexpr Rgb8 kFlowers[] = {rgb(0xc9472f), rgb(0xe3c23c), rgb(0xe9e4d8), rgb(0x8a5cb8)};
    const Rgb8 grass = mixed(Surface::grass_colour(p), rgb(0x6f9440), 0.3);
    const bool flower = u < share * 0.35 * meadow && p.moisture > 0.4;
    return coloured(Material::kLowVegetation, flower ? kFlowers[p.hash >> 50 & 3] : grass);
}

}  // namespace terravox::procedural
