#pragma once

#include <atomic>
#include <map>
#include <mutex>
#include <set>

#include "common/util/error.hpp"
#include "voxelserver/serve/map/top_cache.hpp"

namespace terravox::test {

inline map::ColumnTop land_at(std::int32_t x, std::int32_t z) {
    const auto hash =
        static_cast<std::uint32_t>(x) * 2654435761U ^ static_cast<std::uint32_t>(z) * 2246822519U;
    if ((((std::int64_t{x} + 3) >> 5) & 7) == 3 && (((std::int64_t{z} + 5) >> 4) & 3) == 2)
        return {};  // a hole, at no round place
    const auto material = ((x >> 6) & 3) == 1 ? voxel::Material::kWater : voxel::Material::kGrass;
    return {static_cast<std::int32_t>(x / 3 - z / 5 + static_cast<std::int32_t>(hash >> 28)),
            {static_cast<std::uint8_t>(hash), static_cast<std::uint8_t>(hash >> 8),
             static_cast<std::uint8_t>(hash >> 16)},
            material};
}

/// Land without end, made one box column at a time; every 13th box column is empty. Counts, can
/// fail, and knows what it has made.
class MadeUpLand final : public map::TopSource {
public:
    /// @param alike all box columns are the same one: for lands so large that they would not fit
    explicit MadeUpLand(int zooms, bool alike = false)
        : m_alike(alike ? build(1, 1) : nullptr), m_areas(zooms) {}

    static bool empty_column(std::int32_t bx, std::int32_t bz) {
        return (std::int64_t{bx} * 5 + bz) % 13 == 0;
    }

    [[nodiscard]] map::Top top(std::int32_t bx, std::int32_t bz, bool make) override {
        ++requests;
        const std::lock_guard lock(m_mutex);
        if (failing.contains({bx, bz}) && make)
            throw util::Error("the square is damaged");
        auto found = m_made.find({bx, bz});
        if (found == m_made.end()) {
            if (!make)
                return {};
            found = m_made.emplace(std::pair{bx, bz}, m_alike ? m_alike : build(bx, bz)).first;
            m_areas.add(bx, bz);
        }
        return {found->second, true, {}};
    }
    [[nodiscard]] std::uint64_t version(const map::TileArea& area) override {
        return m_areas.version(area);
    }

    /// As a cache that had no room.
    void forget_all() {
        const std::lock_guard lock(m_mutex);
        m_made.clear();
    }
    [[nodiscard]] std::set<std::pair<std::int32_t, std::int32_t>> made() {
        const std::lock_guard lock(m_mutex);
        std::set<std::pair<std::int32_t, std::int32_t>> out;
        for (const auto& [place, top] : m_made)
            out.insert(place);
        return out;
    }

    std::atomic<int> requests{0};
    std::set<std::pair<std::int32_t, std::int32_t>> failing;  ///< set before the first request

private:
    static std::shared_ptr<const map::BoxTop> build(std::int32_t bx, std::int32_t bz) {
        if (empty_column(bx, bz))
            return nullptr;
        auto out = std::make_shared<map::BoxTop>();
        for (int i = 0; i < 64 * 64; ++i)
            out->columns[static_cast<std::size_t>(i)] = land_at(bx * 64 + i % 64, bz * 64 + i / 64);
        return out;
    }
    const std::shared_ptr<const map::BoxTop> m_alike;
    std::mutex m_mutex;
    std::map<std::pair<std::int32_t, std::int32_t>, std::shared_ptr<const map::BoxTop>> m_made;
    map::MadeAreas m_areas;
};

}  // namespace terravox::test
