#pragma once

#include <cstdint>

#include "raytracer/core/random.hpp"
#include "raytracer/core/ray_state.hpp"

namespace terravox::shade {

/// A part of a voxel's face whose light is kept: all of the face, or one of 2^split x 2^split equal
/// squares of it. A plain value that names the cell the same way on every machine.
struct FaceCell {
    /// A face is cut into at most this many parts along each edge, as a power of two.
    static constexpr int kMaxSplit = 4;
    /// Bounces that a key can name; more count as this many.
    static constexpr int kMaxBounces = 511;

    core::VoxelCoord voxel;  ///< of level()
    std::uint32_t bits = 0;  ///< level, face, fineness, split, place on the face, kind of light

    FaceCell() = default;
    /// @param fine rays that start here see holes between near leaves
    FaceCell(core::VoxelCoord at, int level, core::Face face, bool fine) noexcept
        : voxel(at),
          bits(static_cast<std::uint32_t>(level) | static_cast<std::uint32_t>(face) << 5 |
               (fine ? 1U << 8 : 0U) | kUsed) {}
    /// The part of the face at (u, v) of its 2^split x 2^split parts.
    [[nodiscard]] FaceCell part(int split, std::uint32_t u, std::uint32_t v) const noexcept {
        FaceCell out = *this;
        out.bits |= static_cast<std::uint32_t>(split) << 9 | u << 12 | v << 16;
        return out;
    }
    /// The key of a light of this cell.
    /// @param bounces that the light may have had before it arrives
    /// @param seen whether a camera sees the face: gathered by many rays, without the sun
    [[nodiscard]] FaceCell light(int bounces, bool seen) const noexcept {
        FaceCell out = *this;
        const int counted = bounces < kMaxBounces ? bounces : kMaxBounces;
        out.bits |= static_cast<std::uint32_t>(counted) << 20 | (seen ? 1U << 29 : 0U);
        return out;
    }
    [[nodiscard]] FaceCell cell() const noexcept {
        FaceCell out = *this;
        out.bits &= kUsed | 0xfffffU;
        return out;
    }

    [[nodiscard]] int level() const noexcept { return static_cast<int>(bits & 31); }
    [[nodiscard]] core::Face face() const noexcept {
        return static_cast<core::Face>(bits >> 5 & 7);
    }
    [[nodiscard]] bool fine() const noexcept { return (bits >> 8 & 1) != 0; }
    [[nodiscard]] int split() const noexcept { return static_cast<int>(bits >> 9 & 7); }
    [[nodiscard]] int u() const noexcept { return static_cast<int>(bits >> 12 & 15); }
    [[nodiscard]] int v() const noexcept { return static_cast<int>(bits >> 16 & 15); }
    [[nodiscard]] int bounces() const noexcept { return static_cast<int>(bits >> 20 & 511); }
    [[nodiscard]] bool seen() const noexcept { return (bits >> 29 & 1) != 0; }
    /// False for the value of the default constructor alone.
    [[nodiscard]] bool used() const noexcept { return bits != 0; }

    [[nodiscard]] std::uint64_t hash() const noexcept {
        return core::hash64(
            static_cast<std::uint32_t>(voxel.x) |
                static_cast<std::uint64_t>(static_cast<std::uint32_t>(voxel.z)) << 32,
            static_cast<std::uint32_t>(voxel.y) | static_cast<std::uint64_t>(bits) << 32);
    }
    friend bool operator==(const FaceCell&, const FaceCell&) = default;

private:
    static constexpr std::uint32_t kUsed = 1U << 31;
};

struct FaceCellHash {
    [[nodiscard]] std::size_t operator()(const FaceCell& cell) const noexcept {
        return static_cast<std::size_t>(cell.hash());
    }
};

}  // namespace terravox::shade
