#include "voxelserver/make/voxelize/steps/tree_places.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace terravox::voxelize {
namespace {

constexpr double kAround_m = 2;  // returns of one crown vary within this
constexpr std::int64_t kNoTop = std::numeric_limits<std::int64_t>::min();

}  // namespace

TreePlaces::TreePlaces(const Window& window, const ClassTable& classes, double voxel_m)
    : m_window(window),
      m_classes(classes),
      m_radius(std::clamp(static_cast<int>(std::lround(kAround_m / voxel_m)), 1, kMaxRadius)),
      m_tops(kCount, kNoTop),
      m_next(kCount),
      m_known(kCount) {
    // Each is read by all columns around it.
    constexpr int kPatch = grid::kPatchSize;
    for (int z = -kMargin; z < kPatch + kMargin; ++z)
        for (const auto& [from, to] :
             {std::pair{-kMargin, 0}, {0, kPatch}, {kPatch, kPatch + kMargin}}) {
            const PatchColumns& patch = window.patch_at(from, z);
            for (int x = from; x < to; ++x) {
                const auto i = static_cast<std::size_t>((z & 63) * kPatch + (x & 63));
                const std::uint32_t end = patch.objects_begin[i + 1];
                if (end != patch.objects_begin[i])
                    m_tops[index(x, z)] = top(patch.objects[end - 1]);
            }
        }
}

// The height of a column's highest return in 1/256 voxel, where it may be foliage.
std::int64_t TreePlaces::top(const ObjectVoxel& highest) const noexcept {
    const Role role = m_classes.meaning[highest.source_class].role;
    if (role != Role::kVegetation && role != Role::kSurface)
        return kNoTop;
    return std::int64_t{highest.y} * 256 + highest.fraction;
}

// Equally high columns: the northernmost, then the westernmost, so that all patches agree.
TreePlaces::Place TreePlaces::uphill(Place from) const noexcept {
    Place best = from;
    std::int64_t highest = m_tops[index(from.x, from.z)];
    for (int z = from.z - m_radius; z <= from.z + m_radius; ++z)
        for (int x = from.x - m_radius; x <= from.x + m_radius; ++x) {
            const std::int64_t height = m_tops[index(x, z)];
            const bool before = z < best.z || (z == best.z && x < best.x);
            if (height == kNoTop || height < highest || (height == highest && !before))
                continue;
            highest = height;
            best = {static_cast<std::int16_t>(x), static_cast<std::int16_t>(z)};
        }
    return best;
}

std::array<std::int32_t, 2> TreePlaces::at(int x, int z) {
    Place place{static_cast<std::int16_t>(x), static_cast<std::int16_t>(z)};
    for (int jump = 0; jump < kJumps; ++jump) {
        const std::size_t i = index(place.x, place.z);
        if (m_known[i] == 0) {
            m_next[i] = uphill(place);
            m_known[i] = 1;
        }
        const Place next = m_next[i];
        if (next.x == place.x && next.z == place.z)
            break;
        place = next;
    }
    return {m_window.middle.x0() + place.x, m_window.middle.z0() + place.z};
}

}  // namespace terravox::voxelize
