#include "voxelserver/make/voxelize/steps/isolated.hpp"

#include <cmath>
#include <cstdlib>

namespace terravox::voxelize {
namespace {

constexpr int kAround = 2;
constexpr int kAbove = 3;

bool near(const Surface& s, std::int32_t y) {
    return s.seen() && std::abs(static_cast<std::int32_t>(std::floor(s.height)) - y) <= kAbove;
}

bool anything_near(const Window& window, int x, int z, std::int32_t y, bool own) {
    for (const ObjectVoxel& o : window.objects(x, z)) {
        const std::int32_t dy = std::abs(o.y - y);
        if (dy <= kAbove && !(own && dy == 0))
            return true;
    }
    const Column& column = window.column(x, z);
    return near(column.roof, y) || near(column.deck, y) || near(column.ground, y);
}

}  // namespace

bool isolated(const Window& window, int x, int z, std::int32_t y) {
    // From the inside out: nearly every point has a close neighbour.
    if (anything_near(window, x, z, y, true))
        return false;
    for (int r = 1; r <= kAround; ++r)
        for (int dz = -r; dz <= r; ++dz)
            for (int dx = -r; dx <= r; dx += dz == -r || dz == r ? 1 : 2 * r)
                if (anything_near(window, x + dx, z + dz, y, false))
                    return false;
    return true;
}

}  // namespace terravox::voxelize
