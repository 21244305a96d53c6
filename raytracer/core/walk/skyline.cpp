#include "raytracer/core/walk/skyline.hpp"

#include <algorithm>

namespace terravox::walk {
namespace {

constexpr std::int32_t kAllAir = std::numeric_limits<std::int32_t>::min();

int shift_of(int size) noexcept {
    return LevelCut::kSideBits + 2 * size;
}

}  // namespace

Skyline::Skyline(BlockReader& reader, const LevelCut& cut) : m_reader(reader), m_cut(cut) {
    for (auto& table : m_squares)
        table.resize(std::size_t{1} << 2 * kSlotBits);
}

int Skyline::open_above(const core::RayState& ray) {
    int open = 0;
    for (int size = 0; size < kSizes && ray.voxel[1] >= lowest_free(size, ray); ++size)
        open = shift_of(size);
    return open;
}

Skyline::Square& Skyline::slot(int size, std::int32_t x, std::int32_t z) noexcept {
    constexpr std::int32_t kMask = (1 << kSlotBits) - 1;
    const std::int32_t place = (x & kMask) | (z & kMask) << kSlotBits;
    return m_squares[static_cast<std::size_t>(size)][static_cast<std::size_t>(place)];
}

// What is unknown is looked up again now and then: boxes arrive while the picture is made.
std::int32_t Skyline::lowest_free(int size, const core::RayState& ray) {
    constexpr int kLookInterval = 32;
    const std::int32_t x = ray.voxel[0] >> shift_of(size);
    const std::int32_t z = ray.voxel[2] >> shift_of(size);
    Square& square = slot(size, x, z);
    if (square.x != x || square.z != z || square.level != ray.level)
        square = {x, z, kUnknown, ray.level, 0};
    if (square.free_from == kUnknown && square.lookups++ % kLookInterval == 0)
        square.free_from = size == 0 ? look_down(square) : highest_of_parts(size, square);
    return square.free_from;
}

std::int32_t Skyline::look_down(const Square& column) {
    const voxel::VoxelBounds& bounds = m_cut.bounds(column.level);
    for (std::int32_t by = (bounds.max[1] - 1) >> 8; by >= bounds.min[1] >> 8; --by) {
        const blocks::Block* block = m_reader.get({column.level, column.x, by, column.z});
        if (block == nullptr || block->hole)
            return kUnknown;
        if (block->box && block->box->top() > 0)
            return by * voxel::kBoxSizeY + block->box->top();
    }
    return kAllAir;
}

// Only of what rays have asked for before: looking at columns far from every ray would take room
// in memory from boxes that are needed.
std::int32_t Skyline::highest_of_parts(int size, const Square& square) noexcept {
    const voxel::VoxelBounds& bounds = m_cut.bounds(square.level);
    const int shift = shift_of(size - 1);
    std::int32_t highest = kAllAir;
    for (int part = 0; part < 16; ++part) {
        const std::int32_t x = square.x * 4 + (part & 3);
        const std::int32_t z = square.z * 4 + (part >> 2);
        const bool outside = x < bounds.min[0] >> shift || x > (bounds.max[0] - 1) >> shift ||
                             z < bounds.min[2] >> shift || z > (bounds.max[2] - 1) >> shift;
        if (outside)
            continue;
        const Square& known = slot(size - 1, x, z);
        if (known.x != x || known.z != z || known.level != square.level ||
            known.free_from == kUnknown)
            return kUnknown;
        highest = std::max(highest, known.free_from);
    }
    return highest;
}

}  // namespace terravox::walk
