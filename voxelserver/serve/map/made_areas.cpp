#include "voxelserver/serve/map/made_areas.hpp"

#include "common/voxel/morton.hpp"

namespace terravox::map {

std::size_t MadeAreas::AreaHash::operator()(const TileArea& area) const noexcept {
    return static_cast<std::size_t>(voxel::morton_encode(area.x, area.zooms_out, area.z));
}

void MadeAreas::add(std::int32_t bx, std::int32_t bz) {
    const auto tile_of = [](std::int64_t box) { return static_cast<std::int32_t>(box >> 2); };
    static_assert(kTileBoxes == 4);
    const std::lock_guard lock(m_mutex);
    ++m_clock;
    for (std::int32_t z = tile_of(std::int64_t{bz} - 1); z <= tile_of(std::int64_t{bz} + 1); ++z)
        for (std::int32_t x = tile_of(std::int64_t{bx} - 1); x <= tile_of(std::int64_t{bx} + 1);
             ++x)
            for (int out = 0; out < m_zooms; ++out)
                m_versions[{out, x >> out, z >> out}] = m_clock;
}

std::uint64_t MadeAreas::version(const TileArea& area) const {
    const std::lock_guard lock(m_mutex);
    const auto found = m_versions.find(area);
    return found == m_versions.end() ? 0 : found->second;
}

}  // namespace terravox::map
