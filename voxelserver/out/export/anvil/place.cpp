#include "voxelserver/out/export/anvil/place.hpp"

#include <algorithm>

#include "common/util/error.hpp"

namespace terravox::exports::anvil {
namespace {

constexpr std::int64_t kLowest = -2032, kEnd = 2032;  // limits of a dimension
constexpr std::int64_t kUsualLowest = -64;
constexpr std::int64_t kUsualEnd = 320;
// Above the highest voxel of a high world, to build and fly in.
constexpr std::int64_t kHeadroom = 64;
// The border of a world lies just beyond, with the centre at 0.
constexpr std::int64_t kFarthest = 29'999'000;

std::int64_t floor_to(std::int64_t value, std::int64_t step) noexcept {
    return (value >= 0 ? value / step : -((step - 1 - value) / step)) * step;
}
std::int64_t ceil_to(std::int64_t value, std::int64_t step) noexcept {
    return -floor_to(-value, step);
}

/// @return the least level at which a part of `size` voxels of `level` fits into `max_size`
int fitting_level(int level, std::int64_t size, std::int64_t max_size) noexcept {
    while (size > max_size) {
        size = (size + 1) / 2;
        ++level;
    }
    return level;
}

[[noreturn]] void refuse(const char* dimension, std::int64_t size, std::int64_t max_size,
                         int level) {
    throw util::UsageError("write a world for Minecraft: " + std::to_string(size) + " voxels " +
                           dimension + "; allowed: up to " + std::to_string(max_size) +
                           " blocks, that is --level " + std::to_string(level) +
                           " or coarser, or a part of it");
}

void place_heights(const Part& part, Place& place) {
    const std::int64_t low = floor_to(part.bounds.min[1], kSectionSize);
    const std::int64_t end = ceil_to(part.bounds.max[1], kSectionSize);
    const std::int64_t max_size = kEnd - kLowest;
    // Two sections fewer at a coarser level, where the lowest and highest voxel need not be aligned
    // to sections.
    if (end - low > max_size)
        refuse("high", std::int64_t{part.bounds.max[1]} - part.bounds.min[1], max_size,
               fitting_level(part.level, end - low, max_size - 2 * kSectionSize));
    if (low >= kUsualLowest && end <= kUsualEnd)
        return;
    if (end - low <= kUsualEnd - kUsualLowest) {
        place.offset[1] = static_cast<std::int32_t>(low - kUsualLowest);
        return;
    }
    const std::int64_t offset = low < kLowest || end > kEnd ? low - kLowest : 0;
    place.offset[1] = static_cast<std::int32_t>(offset);
    place.min_y = static_cast<std::int32_t>(low - offset);
    place.height =
        static_cast<std::int32_t>(std::min(end - offset + kHeadroom, kEnd) - place.min_y);
}

}  // namespace

Place place_of(const Part& part) {
    Place place;
    for (const std::size_t axis : {std::size_t{0}, std::size_t{2}}) {
        const std::int64_t low = part.bounds.min[axis];
        const std::int64_t end = part.bounds.max[axis];
        constexpr std::int64_t kWidest = 2 * (kFarthest - kRegionSize);
        if (end - low > kWidest)
            refuse("wide", end - low, kWidest, fitting_level(part.level, end - low, kWidest));
        place.offset[axis] =
            static_cast<std::int32_t>(floor_to((low + end) / 2 + kRegionSize / 2, kRegionSize));
    }
    place_heights(part, place);
    return place;
}

}  // namespace terravox::exports::anvil
