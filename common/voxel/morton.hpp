#pragma once

#include <cstdint>

namespace terravox::voxel {

/// Interleaves three coordinates, x in the lowest bit of each triple, then y, then z. Each
/// coordinate is taken modulo 2^21 (so [-2^20, 2^20) is one to one); the result has 63 bits. The
/// result is the same on every CPU; uses BMI2 (pdep) where available.
/// Ref: Morton, "A computer oriented geodetic data base and a new technique in file sequencing",
/// IBM 1966.
[[nodiscard]] std::uint64_t morton_encode(std::int32_t x, std::int32_t y, std::int32_t z) noexcept;

/// The same with shifts and masks only: the reference for tests, and the implementation for CPUs
/// without BMI2.
[[nodiscard]] std::uint64_t morton_encode_portable(std::int32_t x, std::int32_t y,
                                                   std::int32_t z) noexcept;

struct MortonCoord {
    std::int32_t x, y, z;  ///< each in [-2^20, 2^20)
};
[[nodiscard]] MortonCoord morton_decode(std::uint64_t code) noexcept;

}  // namespace terravox::voxel
