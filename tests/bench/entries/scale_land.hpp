#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/voxel/box.hpp"

namespace terravox::bench {

/// Some thing above the ground of one column: voxels [y0, y1); none when y1 <= y0.
struct LandRun {
    std::int16_t y0 = 0;
    std::int16_t y1 = 0;
    voxel::Material material = voxel::Material::kAir;  ///< of the topmost voxel
    voxel::Material beneath = voxel::Material::kAir;   ///< of the others
    voxel::Rgb8 colour;
    voxel::Rgb8 colour_beneath;
    [[nodiscard]] bool empty() const noexcept { return y1 <= y0; }
};

/// One column of the land: solid ground below y = ground, then water below y = water if that is
/// higher, then runs.
struct LandColumn {
    std::int16_t ground = 0;
    std::int16_t water = 0;
    voxel::Material surface = voxel::Material::kGrass;
    voxel::Rgb8 colour;
    float shade = 1;              ///< brightness of this column's colours
    std::array<LandRun, 2> runs;  ///< an earlier one hides a later one where both are
};

/// An endless synthetic landscape of 1 m voxels: mountains, lakes, fields, woods, villages and
/// roads. A pure function of a seed and a place, the same on every machine (whole numbers, and + -
/// * / on doubles). All voxels lie in [0, kHighest). Immutable, so thread-safe.
class Land {
public:
    static constexpr int kHighest = 256;
    static constexpr int kWaterLevel = 84;

    explicit Land(std::uint64_t seed) : m_seed(seed) {}

    /// Columns of [x0, x0 + side) x [z0, z0 + side), row by row from the north-west.
    [[nodiscard]] std::vector<LandColumn> columns(std::int32_t x0, std::int32_t z0, int side) const;
    /// Of the ground, before lakes fill it: metres, [8, 225].
    [[nodiscard]] double height(std::int32_t x, std::int32_t z) const noexcept;
    [[nodiscard]] std::uint64_t seed() const noexcept { return m_seed; }

private:
    std::uint64_t m_seed;
};

}  // namespace terravox::bench
