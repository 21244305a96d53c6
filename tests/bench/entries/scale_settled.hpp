#pragma once

#include <cstdint>
#include <cstdlib>
#include <optional>
#include <vector>

#include "tests/bench/entries/scale_land.hpp"

namespace terravox::bench {

/// A house with a gable roof, its edges along the axes.
struct LandHouse {
    std::int32_t x = 0, z = 0;   ///< its middle column
    int half_x = 4, half_z = 6;  ///< columns on either side of it
    int eaves = 0;               ///< y of the lowest roof
    std::uint64_t hash = 0;
    /// @param around columns of yard that count as well
    [[nodiscard]] bool covers(std::int32_t px, std::int32_t pz, int around) const noexcept {
        return std::abs(px - x) <= half_x + around && std::abs(pz - z) <= half_z + around;
    }
    /// One past the highest voxel of a covered column.
    [[nodiscard]] int roof(std::int32_t px, std::int32_t pz) const noexcept {
        const int aside = half_x < half_z ? std::abs(px - x) : std::abs(pz - z);
        return eaves + (3 * (4 - aside) + 2) / 4;
    }
};

/// What people built on a square piece of land: villages on a grid of 900 m cells, roads between
/// neighbours, houses on lots.
class SettledLand {
public:
    /// @param side in columns; what stands up to 40 columns around the piece is known, too
    SettledLand(const Land& land, std::int32_t x0, std::int32_t z0, int side);

    /// To the middle of the nearest road, in columns; far away a huge number.
    [[nodiscard]] double road_distance(std::int32_t x, std::int32_t z) const noexcept;
    [[nodiscard]] const LandHouse* house_at(std::int32_t x, std::int32_t z,
                                            int around) const noexcept;
    [[nodiscard]] bool in_village(std::int32_t x, std::int32_t z) const noexcept;

private:
    struct Village {
        std::int32_t x = 0;
        std::int32_t z = 0;
        std::int32_t radius = 0;
    };
    struct Road {
        double x0;
        double z0;
        double x1;
        double z1;
    };
    [[nodiscard]] std::optional<Village> village(std::int32_t cell_x,
                                                 std::int32_t cell_z) const noexcept;
    [[nodiscard]] std::optional<LandHouse> house(std::int32_t lot_x,
                                                 std::int32_t lot_z) const noexcept;
    /// 0 in the middle of a village, 1 at its edge; nullopt outside.
    [[nodiscard]] std::optional<double> place_in_village(std::int32_t x,
                                                         std::int32_t z) const noexcept;
    const Land& m_land;
    std::vector<Village> m_villages;
    std::vector<Road> m_roads;
    std::vector<LandHouse> m_houses;
};

}  // namespace terravox::bench
