#pragma once

#include <cmath>
#include <cstdint>

#include "common/voxel/material.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/survey/hash.hpp"

namespace terravox::bench {

/// A hash of a place on some grid.
[[nodiscard]] constexpr std::uint64_t place_hash(std::uint64_t seed, std::int32_t x,
                                                 std::int32_t z) noexcept {
    return survey::mix64(seed ^ (std::uint64_t{static_cast<std::uint32_t>(x)} << 32 |
                                 static_cast<std::uint32_t>(z)));
}
/// Bits [16 part, 16 part + 16) of a hash as a number in [0, 1); part in [0, 4).
[[nodiscard]] constexpr double unit_of(std::uint64_t hash, int part) noexcept {
    return static_cast<double>(hash >> (16 * part) & 0xFFFF) * 0x1p-16;
}

/// Smooth noise of whole columns in [-1, 1], features `size` columns wide: a function of its
/// arguments, with the same bits everywhere.
[[nodiscard]] inline double value_noise(std::uint64_t seed, std::int32_t x, std::int32_t z,
                                        std::int32_t size) noexcept {
    const std::int32_t cx = voxel::floor_div(x, size);
    const std::int32_t cz = voxel::floor_div(z, size);
    const double fx = static_cast<double>(x - cx * size) / size;
    const double fz = static_cast<double>(z - cz * size) / size;
    const double sx = fx * fx * (3 - 2 * fx);
    const double sz = fz * fz * (3 - 2 * fz);
    const auto corner = [&](int dx, int dz) {
        return static_cast<double>(place_hash(seed, cx + dx, cz + dz) >> 11) * 0x1p-52 - 1;
    };
    const double north = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * sx;
    const double south = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * sx;
    return north + (south - north) * sz;
}

/// The colour with its brightness times `factor`.
[[nodiscard]] inline voxel::Rgb8 shaded(voxel::Rgb8 colour, double factor) noexcept {
    const auto channel = [&](std::uint8_t v) {
        return static_cast<std::uint8_t>(std::fmin(255, v * factor + 0.5));
    };
    return {channel(colour.r), channel(colour.g), channel(colour.b)};
}

}  // namespace terravox::bench
