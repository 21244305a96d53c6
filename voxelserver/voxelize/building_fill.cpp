#include "voxelserver/voxelize/building_fill.hpp"

#include <algorithm>
#include <array>

namespace terravox::voxelize {
namespace {

constexpr int kRoofsAround = 5;           // of eight: a gap between points
constexpr int kRoofsAroundCourtyard = 7;  // of eight, when the ground itself was seen through the gap

Surface roof_of(const Window& window, int x, int z) {
    const Column& own = window.column(x, z);
    if (own.roof.seen()) return own.roof;
    std::array<Surface, 8> around;
    int count = 0;
    for (int dz = -1; dz <= 1; ++dz)
        for (int dx = -1; dx <= 1; ++dx)
            if (const Surface& roof = window.column(x + dx, z + dz).roof; roof.seen()) around[static_cast<std::size_t>(count++)] = roof;
    const bool open = own.ground.seen() || own.water.seen();
    if (count < (open ? kRoofsAroundCourtyard : kRoofsAround)) return {};
    const auto middle = around.begin() + count / 2;
    std::nth_element(around.begin(), middle, around.begin() + count, [](const Surface& a, const Surface& b) { return a.height < b.height; });
    return *middle;
}

}  // namespace

Margined<Surface> close_roofs(const Window& window) {
    Margined<Surface> out;
    constexpr int kMargin = Margined<Surface>::kMargin;
    for (int z = -kMargin; z < kPatchSize + kMargin; ++z)
        for (int x = -kMargin; x < kPatchSize + kMargin; ++x) out.at(x, z) = roof_of(window, x, z);
    return out;
}

}  // namespace terravox::voxelize
