#include "voxelserver/make/worlds/procedural/tree_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "voxelserver/make/worlds/procedural/hash.hpp"

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

Size size_of(const Tree& t) noexcept {
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
    return size_of(tree).radius;
}

TreeRuns tree_runs(const Tree& tree, int dx, int dz) noexcept {
    const Size size = size_of(tree);
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

}  // namespace terravox::procedural
