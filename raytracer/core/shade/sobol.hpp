#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

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

}  // namespace terravox::shade
