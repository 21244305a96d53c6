#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raytracer/core/base/random.hpp"

namespace terravox::shade {

/// The recurrence of a dimension of a Sobol' sequence: a primitive polynomial over the integers
/// modulo 2, and the first direction numbers.
struct SobolDimension {
    std::uint32_t degree = 0;
    std::uint32_t coefficients = 0;  ///< without the first and the last one, which are 1
    std::array<std::uint32_t, 3> first{};
};
/// Dimensions 1 to 3; dimension 0 is the index with its bits reversed, and not made here.
/// Ref: Joe and Kuo, "Constructing Sobol sequences with better two-dimensional projections", SIAM
/// J. Sci. Comput. 30(5), 2008 (new-joe-kuo-6).
inline constexpr std::array<SobolDimension, 3> kSobolDimensions{
    {{1, 0, {1}}, {2, 1, {1, 3}}, {3, 1, {1, 3, 1}}}};

/// The columns of a dimension's generator matrix.
[[nodiscard]] constexpr std::array<std::uint32_t, 32> sobol_columns(
    const SobolDimension& of) noexcept {
    std::array<std::uint32_t, 32> out{};
    for (std::uint32_t i = 0; i < 32; ++i) {
        if (i < of.degree) {
            out[i] = of.first[i] << (31 - i);
            continue;
        }
        out[i] = out[i - of.degree] ^ out[i - of.degree] >> of.degree;
        for (std::uint32_t k = 1; k < of.degree; ++k)
            if ((of.coefficients >> (of.degree - 1 - k) & 1) != 0)
                out[i] ^= out[i - k];
    }
    return out;
}

/// Products of a generator matrix with bytes: one table for each byte of the index.
using SobolTables = std::array<std::array<std::uint32_t, 256>, 4>;
[[nodiscard]] constexpr SobolTables sobol_tables(const SobolDimension& of) noexcept {
    SobolTables out{};
    const std::array<std::uint32_t, 32> columns = sobol_columns(of);
    for (std::size_t byte = 0; byte < 4; ++byte)
        for (std::uint32_t v = 0; v < 256; ++v)
            for (std::size_t bit = 0; bit < 8; ++bit)
                if ((v >> bit & 1) != 0)
                    out[byte][v] ^= columns[8 * byte + bit];
    return out;
}
template <int kDimension>
inline constexpr SobolTables kSobolTables = sobol_tables(kSobolDimensions[kDimension - 1]);

/// A number of the sequence at an index (not in the order of Gray codes), as 32 bits after the
/// binary point.
/// @tparam kDimension 1 to 3
template <int kDimension>
[[nodiscard]] constexpr std::uint32_t sobol_number(std::uint32_t index) noexcept {
    static_assert(kDimension >= 1 && kDimension <= static_cast<int>(kSobolDimensions.size()));
    const SobolTables& tables = kSobolTables<kDimension>;
    return tables[0][index & 255] ^ tables[1][index >> 8 & 255] ^ tables[2][index >> 16 & 255] ^
           tables[3][index >> 24];
}

/// Random numbers for one sample of one pixel: a function of pixel, sample and dimension alone, so
/// that the order of calls does not matter. In each dimension (a pair of numbers) the samples of a
/// pixel, counted from 0, are evenly spread at every power of two. Ref: the first two dimensions of
/// the Sobol' sequence, padded; in_pixel() and across_pixel() are its first four together; Burley,
/// "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020; hash constants of Vegdahl, 2021.
class Sampler {
public:
    struct Pair {
        double u, v;  ///< [0, 1)
    };
    Sampler() = default;
    /// @param seed changes the noise of the picture
    Sampler(int x, int y, std::uint32_t sample, int seed = 0) noexcept
        : m_pixel(core::hash64(
              core::hash64(static_cast<std::uint64_t>(static_cast<std::uint32_t>(y)) << 32 |
                           static_cast<std::uint32_t>(x)) +
              static_cast<std::uint32_t>(seed))),
          m_sample(sample) {}

    [[nodiscard]] Pair pair(std::uint32_t dimension) const noexcept {
        const std::uint64_t seed = core::hash64(m_pixel, dimension);
        const std::uint32_t index = scramble(m_sample, static_cast<std::uint32_t>(seed));
        const std::uint64_t more = core::hash64(seed);
        return {unit(reversed_scramble(index, static_cast<std::uint32_t>(more))),
                unit(scramble(sobol_number<1>(index), static_cast<std::uint32_t>(more >> 32)))};
    }
    /// The point of the pixel that the sample's ray goes through.
    [[nodiscard]] Pair in_pixel() const noexcept { return pair(kPixelPoint); }
    /// The point of the lens that it starts from.
    [[nodiscard]] Pair on_lens() const noexcept { return pair(kLensPoint); }
    /// For choices at the first surface that the ray meets, whose light differs across the pixel:
    /// spread together with in_pixel(). Each number is evenly spread at every power of two, the two
    /// of them nearly as well as those of pair(). Two such dimensions are not spread together: use
    /// them for parts of the light that are added, such as the sky's and a bounce's.
    [[nodiscard]] Pair across_pixel(std::uint32_t dimension) const noexcept {
        const std::uint32_t index =
            scramble(m_sample, static_cast<std::uint32_t>(core::hash64(m_pixel, kPixelPoint)));
        const std::uint64_t more = core::hash64(core::hash64(m_pixel, dimension));
        return {unit(scramble(sobol_number<2>(index), static_cast<std::uint32_t>(more))),
                unit(scramble(sobol_number<3>(index), static_cast<std::uint32_t>(more >> 32)))};
    }
    /// One of `count` samplers that share the place of this one: together with those of the other
    /// samples they are evenly spread.
    [[nodiscard]] Sampler part(int i, int count) const noexcept {
        Sampler out = *this;
        out.m_sample = m_sample * static_cast<std::uint32_t>(count) + static_cast<std::uint32_t>(i);
        return out;
    }
    [[nodiscard]] double number(std::uint32_t dimension) const noexcept {
        const std::uint64_t seed = core::hash64(m_pixel, dimension);
        return unit(reversed_scramble(scramble(m_sample, static_cast<std::uint32_t>(seed)),
                                      static_cast<std::uint32_t>(seed >> 32)));
    }

private:
    [[nodiscard]] static constexpr double unit(std::uint32_t v) noexcept { return v * 0x1.0p-32; }
    [[nodiscard]] static constexpr std::uint32_t reverse(std::uint32_t v) noexcept {
        v = (v >> 1 & 0x55555555) | (v & 0x55555555) << 1;
        v = (v >> 2 & 0x33333333) | (v & 0x33333333) << 2;
        v = (v >> 4 & 0x0f0f0f0f) | (v & 0x0f0f0f0f) << 4;
        return __builtin_bswap32(v);
    }
    /// Each bit depends on the bits below it: Owen's scrambling of the reversed number.
    [[nodiscard]] static constexpr std::uint32_t mix_upwards(std::uint32_t v,
                                                             std::uint32_t seed) noexcept {
        v ^= v * 0x3d20adea;
        v += seed;
        v *= (seed >> 16) | 1;
        v ^= v * 0x05526c56;
        v ^= v * 0x53a22864;
        return v;
    }
    [[nodiscard]] static constexpr std::uint32_t scramble(std::uint32_t v,
                                                          std::uint32_t seed) noexcept {
        return reverse(mix_upwards(reverse(v), seed));
    }
    /// scramble(first dimension of the sequence), which is the reversed index.
    [[nodiscard]] static constexpr std::uint32_t reversed_scramble(std::uint32_t index,
                                                                   std::uint32_t seed) noexcept {
        return reverse(mix_upwards(index, seed));
    }

    // Of all dimensions: the others are hashes of 32 bits, which hardly ever are one of these.
    static constexpr std::uint32_t kPixelPoint = 0xffff0000;
    static constexpr std::uint32_t kLensPoint = 0xffff0001;

    std::uint64_t m_pixel = 0;
    std::uint32_t m_sample = 0;
};

}  // namespace terravox::shade
