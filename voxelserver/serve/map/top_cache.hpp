#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "common/util/cache.hpp"
#include "voxelserver/serve/map/made_areas.hpp"
#include "voxelserver/serve/map/top_source.hpp"

namespace terravox::map {

/// The boxes of level 0 of one box column, and the extent of their inputs.
struct ColumnBoxes {
    std::vector<std::shared_ptr<const voxel::Box>> boxes;  ///< nullptr: air
    voxel::InputExtent reach;                              ///< empty = the box column alone
};
/// Fetches a column; called from any thread. With make = false it returns nullopt when not all
/// boxes of the column are available.
/// @throws Error when they cannot be made
using FetchColumn =
    std::function<std::optional<ColumnBoxes>(std::int32_t bx, std::int32_t bz, bool make)>;

/// Box columns seen from above, cached under a byte limit (32 KiB each); their boxes are made and
/// cached elsewhere. Thread-safe.
class TopCache final : public TopSource {
public:
    /// @param zooms zooms of the map = levels of the world
    TopCache(FetchColumn fetch, TopColours colours, int zooms, std::size_t limit_bytes);

    [[nodiscard]] Top top(std::int32_t bx, std::int32_t bz, bool make) override;
    [[nodiscard]] std::uint64_t version(const TileArea& area) override {
        return m_made.version(area);
    }

    /// Must be called when all boxes of a column have become available by other means than top(),
    /// and only after `fetch` can find them: the map may show them from now on. Cheap enough to
    /// call for every column.
    void note_made(std::int32_t bx, std::int32_t bz) { m_made.add(bx, bz); }

    [[nodiscard]] util::CacheStats stats() const { return m_tops.stats(); }

private:
    struct Place {
        std::int32_t bx;
        std::int32_t bz;
        friend bool operator==(const Place&, const Place&) = default;
    };
    struct PlaceHash {
        [[nodiscard]] std::size_t operator()(const Place& place) const noexcept;
    };
    struct Kept {
        std::shared_ptr<const BoxTop> top;
        voxel::InputExtent reach;
    };
    [[nodiscard]] std::shared_ptr<const Kept> kept_of(const ColumnBoxes& column) const;

    const FetchColumn m_fetch;
    const TopColours m_colours;
    MadeAreas m_made;
    util::Cache<Place, Kept, PlaceHash> m_tops;
};

}  // namespace terravox::map
