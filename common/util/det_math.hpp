#pragma once

#include <bit>
#include <cstdint>

namespace terravox::det {

/// Elementary functions that give the same bits on every machine of IEEE arithmetic. The C library picks variants by CPU (with or
/// without fused multiply-add), which may differ in the last bit: enough to break "the picture does not depend on who computed it".
/// Relative error below 1e-14 in the ranges stated; only + - * / are used, in a fixed order.

/// 2^n for n in [-1022, 1023].
[[nodiscard]] constexpr double exp2_int(int n) noexcept { return std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52); }

/// e^x; x below -700 gives 0, above 700 is cut to 700.
[[nodiscard]] constexpr double exp(double x) noexcept {
    if (!(x > -700)) return 0;
    if (x > 700) x = 700;
    constexpr double kLn2 = 0.693147180559945309417;
    const int n = static_cast<int>(x / kLn2 + (x < 0 ? -0.5 : 0.5));
    const double r = x - n * kLn2;  // |r| <= ln 2 / 2
    // Taylor by Horner; 13 terms leave less than 1e-15 for |r| <= 0.347.
    constexpr double kInverseFactorials[] = {1.0, 1.0, 1.0 / 2, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 720, 1.0 / 5040, 1.0 / 40320, 1.0 / 362880,
                                             1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800};
    double sum = kInverseFactorials[13];
    for (int i = 12; i >= 0; --i) sum = sum * r + kInverseFactorials[i];
    return sum * exp2_int(n);
}

/// Natural logarithm of a normal x > 0.
[[nodiscard]] constexpr double log(double x) noexcept {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    int exponent = static_cast<int>(bits >> 52) - 1023;
    double m = std::bit_cast<double>((bits & ((std::uint64_t{1} << 52) - 1)) | std::uint64_t{1023} << 52);  // [1, 2)
    if (m > 1.41421356237309515) m /= 2, ++exponent;
    const double s = (m - 1) / (m + 1), s2 = s * s;  // log m = 2 atanh s, |s| < 0.172
    double power = s, sum = 0;
    for (int i = 1; i <= 23; i += 2) sum += power / i, power *= s2;
    return 2 * sum + exponent * 0.693147180559945309417;
}

/// x^y for x >= 0.
[[nodiscard]] constexpr double pow(double x, double y) noexcept { return x <= 0 ? (y == 0 ? 1 : 0) : exp(y * log(x)); }

}  // namespace terravox::det
