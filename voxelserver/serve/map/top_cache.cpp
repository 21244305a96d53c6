#include "voxelserver/serve/map/top_cache.hpp"

#include <utility>

#include "common/util/error.hpp"
#include "common/voxel/box.hpp"

namespace terravox::map {

std::size_t MadeAreas::AreaHash::operator()(const TileArea& area) const noexcept {
    return static_cast<std::size_t>(voxel::morton_encode(area.x, area.zooms_out, area.z));
}

void MadeAreas::add(std::int32_t bx, std::int32_t bz) {
    const auto to_tile = [](std::int64_t box) { return static_cast<std::int32_t>(box >> 2); };
    static_assert(kTileBoxes == 4);
    const std::lock_guard lock(m_mutex);
    ++m_clock;
    for (std::int32_t z = to_tile(std::int64_t{bz} - 1); z <= to_tile(std::int64_t{bz} + 1); ++z)
        for (std::int32_t x = to_tile(std::int64_t{bx} - 1); x <= to_tile(std::int64_t{bx} + 1);
             ++x)
            for (int out = 0; out < m_zooms; ++out)
                m_versions[{out, x >> out, z >> out}] = m_clock;
}

std::uint64_t MadeAreas::version(const TileArea& area) const {
    const std::lock_guard lock(m_mutex);
    const auto found = m_versions.find(area);
    return found == m_versions.end() ? 0 : found->second;
}

TopCache::TopCache(FetchColumn fetch, TopColours colours, int zooms, std::size_t limit_bytes)
    : m_fetch(std::move(fetch)),
      m_colours(std::move(colours)),
      m_made(zooms),
      m_tops(limit_bytes) {}

std::size_t TopCache::PlaceHash::operator()(const Place& place) const noexcept {
    return static_cast<std::size_t>(voxel::morton_encode(place.bx, 0, place.bz));
}

std::shared_ptr<const TopCache::Kept> TopCache::find_kept(const ColumnBoxes& column) const {
    return std::make_shared<const Kept>(Kept{make_top(column.boxes, m_colours), column.reach});
}

Top TopCache::top(std::int32_t bx, std::int32_t bz, bool make) {
    const Place place{bx, bz};
    const auto measure_bytes = [](const std::shared_ptr<const Kept>& kept) {
        return sizeof(Kept) + (kept->top ? sizeof(BoxTop) : 0);
    };
    std::shared_ptr<const Kept> kept = m_tops.find(place);
    if (kept)
        return {kept->top, true, kept->reach};
    if (make) {
        bool made_here = false;
        const auto make_it = [&] {
            const auto column = m_fetch(bx, bz, true);
            if (!column)
                throw util::Error("make box column " + std::to_string(bx) + "/" +
                                  std::to_string(bz) + ": no boxes came");
            made_here = true;
            return find_kept(*column);
        };
        kept = m_tops.get(place, make_it, measure_bytes);
        // Only after it can be found: a caller that sees the new version must find the column.
        if (made_here)
            m_made.add(bx, bz);
    } else {
        const auto column = m_fetch(bx, bz, false);
        if (!column)
            return {};
        const auto seen = find_kept(*column);
        // May wait for a thread that makes it now, but that thread has the boxes available too.
        kept = m_tops.get(place, [&] { return seen; }, measure_bytes);
    }
    return {kept->top, true, kept->reach};
}

}  // namespace terravox::map
