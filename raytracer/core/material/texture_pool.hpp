#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "raytracer/core/material/appearance.hpp"
#include "raytracer/core/material/texture_list.hpp"

namespace terravox::material {

inline constexpr int kMips = 5;  ///< 16, 8, 4, 2, 1 texels along an edge
/// Offset of each mip in a variant; the last entry is the variant's size.
inline constexpr std::array<std::uint32_t, kMips + 1> kMipAt = {0, 256, 320, 336, 340, 341};

/// Approximates the binary logarithm of x, linearly between powers of two; x must be positive and
/// normal.
[[nodiscard]] inline float rough_log2(float x) noexcept {
    const auto bits = std::bit_cast<std::uint32_t>(x);
    return static_cast<float>(static_cast<int>(bits >> 23) - 127) +
           static_cast<float>(bits & 0x7fffff) * 0x1p-23f;
}

/// Two adjacent mips, and the weight of the second.
struct MipPair {
    int fine = 0;
    float coarse_share = 0;  ///< [0, 1); 0 at the last

    /// @param texels that a pixel covers along an edge
    [[nodiscard]] static MipPair of(float texels) noexcept {
        if (!(texels > 1))
            return {};
        const float at = std::min(rough_log2(texels), static_cast<float>(kMips - 1));
        const int fine = static_cast<int>(at);
        return {fine, at - static_cast<float>(fine)};
    }
};

/// A drawing in the pool.
struct PaintedFace {
    std::uint32_t first = 0;
    std::uint32_t own_first = 0;
    std::uint32_t variants = 0;  ///< 0: nothing is drawn
    Turn turn = Turn::kNone;
    bool metric = false;
    bool layered = false;
    bool has_own = false;
    bool has_holes = false;
};

/// The point of a face's drawing that is looked up.
struct PaintPoint {
    /// Bits of `turn`: 4 exchanges s and t, then 1 mirrors s and 2 mirrors t.
    std::uint32_t variant = 0;
    std::uint32_t turn = 0;
    float s = 0, t = 0;  ///< [0, 1)
    MipPair mips;
};

/// The drawings of all textures with their mips, made at construction. Immutable.
class TexturePool {
public:
    /// Draws, normalises the mean ratio to 1, and makes the mips. A drawing that was added before
    /// is reused.
    [[nodiscard]] PaintedFace add(const Drawing& drawing);
    /// Sets ratio, opacity, own (a ratio to be multiplied by a colour) and own_share.
    void look_up(const PaintedFace& face, const PaintPoint& at, Texel& out) const noexcept;
    /// One texel of one mip: for tests and the sheet of textures.
    [[nodiscard]] Dot dot(const PaintedFace& face, std::uint32_t variant, int mip, int s,
                          int t) const noexcept;
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return (m_ratio.size() + m_own.size()) * sizeof(Packed);
    }

private:
    /// A colour ratio, and opacity or share: four numbers that are loaded and mixed together.
    using Packed = std::array<float, 4>;
    void add_variant(const Canvas& canvas, PaintedFace& face);
    struct Known {
        void (*draw)(Canvas&, int);
        PaintedFace face;
    };
    std::vector<Packed> m_ratio;
    std::vector<Packed> m_own;
    std::vector<Known> m_known;
};

}  // namespace terravox::material
