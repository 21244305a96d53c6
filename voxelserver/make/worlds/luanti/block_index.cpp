#include "voxelserver/make/worlds/luanti/block_index.hpp"

#include <algorithm>

namespace terravox::luanti {
namespace {

constexpr std::int32_t kBlocksAcross = voxel::kBoxSizeX / kBlockVoxels;

}  // namespace

BlockIndex::BlockIndex()
    : m_heights(std::size_t{4} * kFarthestColumn * kFarthestColumn),
      m_min{kFarthestBlock, kFarthestBlock, kFarthestBlock},
      m_max{-kFarthestBlock, -kFarthestBlock, -kFarthestBlock} {
    for (std::size_t level = 0; level < m_holds.size(); ++level)
        m_holds[level].resize(m_heights.size() >> (2 * level));
}

std::size_t BlockIndex::index_of(int level, std::int32_t bx, std::int32_t bz) noexcept {
    const std::int32_t half = kFarthestColumn >> level;
    return static_cast<std::size_t>((bz + half) * 2 * half + bx + half);
}

void BlockIndex::add(const BlockPlace& place) noexcept {
    std::int32_t bx = voxel::floor_div(place.x, kBlocksAcross);
    std::int32_t bz = voxel::floor_div(place.z, kBlocksAcross);
    Heights& heights = m_heights[index_of(0, bx, bz)];
    const bool is_first = heights.begin == heights.end;
    heights.begin = static_cast<std::int16_t>(
        is_first ? place.y : std::min<std::int32_t>(heights.begin, place.y));
    heights.end = static_cast<std::int16_t>(
        is_first ? place.y + 1 : std::max<std::int32_t>(heights.end, place.y + 1));
    for (int level = 0; level <= kTopLevel; ++level) {
        m_holds[static_cast<std::size_t>(level)][index_of(level, bx, bz)] = true;
        bx = voxel::floor_div(bx, 2);
        bz = voxel::floor_div(bz, 2);
    }
    m_min = {std::min(m_min.x, place.x), std::min(m_min.y, place.y), std::min(m_min.z, place.z)};
    m_max = {std::max(m_max.x, place.x), std::max(m_max.y, place.y), std::max(m_max.z, place.z)};
}

voxel::VoxelBounds BlockIndex::bounds() const noexcept {
    if (m_min.x > m_max.x)
        return {};
    const auto begin = [](std::int32_t block) { return block * kBlockVoxels; };
    const auto end = [](std::int32_t block) { return (block + 1) * kBlockVoxels; };
    return {{begin(m_min.x), begin(m_min.y), begin(m_min.z)},
            {end(m_max.x), end(m_max.y), end(m_max.z)}};
}

BlockIndex::Heights BlockIndex::heights(std::int32_t bx, std::int32_t bz) const noexcept {
    const auto fits = [](std::int32_t b) { return b >= -kFarthestColumn && b < kFarthestColumn; };
    return fits(bx) && fits(bz) ? m_heights[index_of(0, bx, bz)] : Heights{};
}

bool BlockIndex::holds(int level, std::int32_t bx, std::int32_t bz) const noexcept {
    const int stored = std::min(level, kTopLevel);
    const std::int32_t half = kFarthestColumn >> stored;
    const auto fits = [&](std::int32_t b) { return b >= -half && b < half; };
    return fits(bx) && fits(bz) &&
           m_holds[static_cast<std::size_t>(stored)][index_of(stored, bx, bz)];
}

}  // namespace terravox::luanti
