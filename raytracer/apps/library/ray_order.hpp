#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace terravox {

/// What the place of a ray in the order depends on.
struct RayStart {
    float x = 0;  ///< where the ray enters the world, horizontally, in any unit; finite
    float z = 0;
    std::uint8_t octant = 0;  ///< signs of the direction, one bit per axis: 0 to 7
};

/// Puts rays that have nothing in common into an order in which neighbours read the same voxels, so
/// that a walk finds them in the processor's caches: by the octant of their directions, and within
/// an octant by the Morton code of the cell in which they start. The cells are 64 x 64 over the
/// area in which the rays start. A counting sort: linear in the number of rays.
/// Use one object per thread.
/// Ref: Garanzha & Loop, "Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray Tracing",
/// Eurographics 2010.
class RayOrder {
public:
    /// @param starts fewer than 2^32
    /// @param order of the same length; becomes a permutation of the indices of `starts`, in which
    ///     rays of the same octant and cell keep their order
    void sort(std::span<const RayStart> starts, std::span<std::uint32_t> order) {
        find_keys(starts);
        m_places.assign(kKeys, 0);
        for (const std::uint16_t key : m_keys)
            ++m_places[key];
        std::uint32_t before = 0;
        for (std::uint32_t& place : m_places)
            before += std::exchange(place, before);
        for (std::size_t i = 0; i < starts.size(); ++i)
            order[m_places[m_keys[i]]++] = static_cast<std::uint32_t>(i);
    }

private:
    static constexpr int kCellBits = 6;  ///< of each axis
    static constexpr float kLastCell = (1 << kCellBits) - 1;
    static constexpr std::size_t kKeys = std::size_t{8} << (2 * kCellBits);

    /// The smallest square that holds all starts.
    struct Area {
        float x;
        float z;
        float cells_per_unit;
    };

    static Area measure_area(std::span<const RayStart> starts) noexcept {
        if (starts.empty())
            return {};
        const auto by_x = [](const RayStart& a, const RayStart& b) { return a.x < b.x; };
        const auto by_z = [](const RayStart& a, const RayStart& b) { return a.z < b.z; };
        const auto [west, east] = std::minmax_element(starts.begin(), starts.end(), by_x);
        const auto [north, south] = std::minmax_element(starts.begin(), starts.end(), by_z);
        const float side = std::max(east->x - west->x, south->z - north->z);
        return {west->x, north->z, side > 0 ? (kLastCell + 1) / side : 0};
    }

    /// The bits of a number of six bits, with a zero before each.
    static std::uint32_t spread(std::uint32_t bits) noexcept {
        bits = (bits | bits << 4) & 0x30F;
        bits = (bits | bits << 2) & 0x333;
        return (bits | bits << 1) & 0x555;
    }

    static std::uint32_t cell(float distance, const Area& area) noexcept {
        return static_cast<std::uint32_t>(std::min(distance * area.cells_per_unit, kLastCell));
    }

    void find_keys(std::span<const RayStart> starts) {
        const Area area = measure_area(starts);
        m_keys.resize(starts.size());
        for (std::size_t i = 0; i < starts.size(); ++i) {
            const RayStart& start = starts[i];
            const std::uint32_t morton =
                spread(cell(start.x - area.x, area)) | spread(cell(start.z - area.z, area)) << 1;
            m_keys[i] =
                static_cast<std::uint16_t>(std::uint32_t{start.octant} << (2 * kCellBits) | morton);
        }
    }

    std::vector<std::uint16_t> m_keys;
    std::vector<std::uint32_t> m_places;
};

}  // namespace terravox
