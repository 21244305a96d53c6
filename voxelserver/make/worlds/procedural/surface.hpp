#pragma once

#include <cstdint>

#include "common/voxel/material.hpp"
#include "voxelserver/make/worlds/procedural/terrain.hpp"

namespace terravox::procedural {

/// One place of the land.
struct Place {
    double height = 0;       ///< of the ground, voxels
    double slope = 0;        ///< rise over run
    double temperature = 0;  ///< at this height
    double moisture = 0;
    double patch = 0;        ///< [-1, 1]: meadows and bare spots some twenty columns wide
    std::uint64_t hash = 0;  ///< of the column
};

/// The make-up of a column of ground, from above.
struct Skin {
    voxel::Material material = voxel::Material::kGrass;
    voxel::Material under = voxel::Material::kSoil;
    voxel::Rgb8 colour;
    voxel::Rgb8 under_colour;
    std::uint8_t under_depth = 3;  ///< voxels of `under` below the topmost; rock below them
};

/// What covers the ground, by climate, height, slope.
class Surface {
public:
    explicit Surface(const Terrain& terrain);

    /// @param x, z column of level 0
    /// @param heights of the terrain there, and three columns east and south of it (kSlopeRun)
    [[nodiscard]] Place place(const Region& region, std::int32_t x, std::int32_t z, double height,
                              double height_east, double height_south) const noexcept;
    /// The climate at a height.
    [[nodiscard]] double temperature_at(const Region& region, double height) const noexcept;
    [[nodiscard]] Skin skin(const Place& place) const noexcept;
    /// Whether water freezes over: floes at first, then snow lies on them.
    [[nodiscard]] static bool freezes(const Place& place) noexcept {
        return place.temperature + 0.05 * place.patch < 0.19;
    }
    [[nodiscard]] static bool snowed_under(const Place& place) noexcept {
        return place.temperature + 0.06 * place.patch < 0.175;
    }
    /// Colour of bare rock: in layers, grey where it is cool, red and yellow where it is hot.
    /// @param y voxel of level 0
    [[nodiscard]] static voxel::Rgb8 rock_colour(double temperature, double moisture,
                                                 double y) noexcept;
    [[nodiscard]] static voxel::Rgb8 grass_colour(const Place& place) noexcept;

    static constexpr int kSlopeRun = 3;  ///< columns over which a slope is measured

private:
    [[nodiscard]] Skin under_water(const Place& place, double depth) const noexcept;
    std::uint64_t m_column_seed;
    std::uint64_t m_patch_seed;
    double m_water;
    double m_world;
};

[[nodiscard]] constexpr voxel::Rgb8 rgb(std::uint32_t code) noexcept {
    return {static_cast<std::uint8_t>(code >> 16), static_cast<std::uint8_t>(code >> 8),
            static_cast<std::uint8_t>(code)};
}
[[nodiscard]] inline voxel::Rgb8 mixed(voxel::Rgb8 a, voxel::Rgb8 b, double share) noexcept {
    const auto channel = [&](std::uint8_t u, std::uint8_t v) {
        return static_cast<std::uint8_t>(u + (v - u) * share + 0.5);
    };
    share = share < 0 ? 0 : share > 1 ? 1 : share;
    return {channel(a.r, b.r), channel(a.g, b.g), channel(a.b, b.b)};
}

}  // namespace terravox::procedural
