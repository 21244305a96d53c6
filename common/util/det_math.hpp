#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace terravox::det {

/// Elementary functions that return the same bits on every machine with IEEE arithmetic. The C
/// library selects variants by CPU (with or without fused multiply-add), which may differ in the
/// last bit: enough to make a picture depend on the machine that rendered it. Relative error below
/// 1e-14 in the stated ranges; uses only + - * / and the exactly rounded sqrt and floor, in a fixed
/// order.

inline constexpr double kPi = 3.141592653589793238463;

/// 2^n for n in [-1022, 1023].
[[nodiscard]] constexpr double exp2_int(int n) noexcept {
    return std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52);
}

/// e^x; x below -700 gives 0, x above 700 is clamped to 700.
[[nodiscard]] constexpr double exp(double x) noexcept {
    if (!(x > -700))
        return 0;
    if (x > 700)
        x = 700;
    // ln 2 in two parts, the first so short that its multiples are exact.
    constexpr double kLn2High = 0x1.62e42feep-1;
    constexpr double kLn2Low = 1.9082149292705877e-10;
    constexpr double kInverseLn2 = 1.44269504088896340736;
    const int n = static_cast<int>(x * kInverseLn2 + (x < 0 ? -0.5 : 0.5));
    const double r = (x - n * kLn2High) - n * kLn2Low;  // |r| <= ln 2 / 2
    // Taylor series; 13 terms leave an error below 1e-15 for |r| <= 0.347. Evaluated in pairs, and
    // pairs of pairs: a dependency chain of four operations instead of thirteen. Ref: Estrin,
    // "Organization of computer systems", 1960.
    const double r2 = r * r;
    const double r4 = r2 * r2;
    const double r8 = r4 * r4;
    const double low = (1 + r) + (1.0 / 2 + r * (1.0 / 6)) * r2;
    const double next = (1.0 / 24 + r * (1.0 / 120)) + (1.0 / 720 + r * (1.0 / 5040)) * r2;
    const double high =
        (1.0 / 40320 + r * (1.0 / 362880)) + (1.0 / 3628800 + r * (1.0 / 39916800)) * r2;
    const double last = 1.0 / 479001600 + r * (1.0 / 6227020800);
    const double sum = (low + next * r4) + (high + last * r4) * r8;
    return sum * exp2_int(n);
}

/// Natural logarithm of a normal x > 0.
[[nodiscard]] constexpr double log(double x) noexcept {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    int exponent = static_cast<int>(bits >> 52) - 1023;
    double m = std::bit_cast<double>((bits & ((std::uint64_t{1} << 52) - 1)) |
                                     std::uint64_t{1023} << 52);  // [1, 2)
    if (m > 1.41421356237309515) {
        m /= 2;
        ++exponent;
    }
    const double s = (m - 1) / (m + 1), s2 = s * s;  // log m = 2 atanh s, |s| < 0.172
    const double s4 = s2 * s2;
    const double s8 = s4 * s4;
    const double s16 = s8 * s8;
    const double low = (1 + s2 * (1.0 / 3)) + (1.0 / 5 + s2 * (1.0 / 7)) * s4;
    const double next = (1.0 / 9 + s2 * (1.0 / 11)) + (1.0 / 13 + s2 * (1.0 / 15)) * s4;
    const double high = (1.0 / 17 + s2 * (1.0 / 19)) + (1.0 / 21 + s2 * (1.0 / 23)) * s4;
    return 2 * (s * (low + next * s8 + high * s16)) + exponent * 0.693147180559945309417;
}

/// x^y for x >= 0.
[[nodiscard]] constexpr double pow(double x, double y) noexcept {
    return x <= 0 ? (y == 0 ? 1 : 0) : exp(y * log(x));
}

/// Sine and cosine of one angle.
struct SinCos {
    double sin;
    double cos;
};

/// Sine and cosine of x radians; absolute error below 1e-15 for |x| <= 1e5. NaN and values beyond
/// 1e9 give the result of 0.
[[nodiscard]] inline SinCos sin_cos(double x) noexcept {
    if (!(x >= -1e9 && x <= 1e9))
        x = 0;
    // Ref: Cody & Waite, "Software Manual for the Elementary Functions", 1980: pi / 2 in three
    // parts, the first two short enough that their multiples are exact.
    constexpr double kHalfPi1 = 1.57079632673412561417;
    constexpr double kHalfPi2 = 6.07710050630396597660e-11;
    constexpr double kHalfPi3 = 2.02226624879595063154e-21;
    const double n = std::floor(x * (2 / kPi) + 0.5);
    const double r = x - n * kHalfPi1 - n * kHalfPi2 - n * kHalfPi3, r2 = r * r;  // |r| <= pi / 4
    // Taylor series; the omitted terms are below 1e-17. Evaluated in pairs, as in exp().
    const double r4 = r2 * r2;
    const double r8 = r4 * r4;
    const double s_low = (-1.0 / 6 + r2 * (1.0 / 120)) + (-1.0 / 5040 + r2 * (1.0 / 362880)) * r4;
    const double s_high = (-1.0 / 39916800 + r2 * (1.0 / 6227020800)) +
                          (-1.0 / 1307674368000 + r2 * (1.0 / 355687428096000)) * r4;
    const double c_low =
        (1.0 / 24 + r2 * (-1.0 / 720)) + (1.0 / 40320 + r2 * (-1.0 / 3628800)) * r4;
    const double c_high = (1.0 / 479001600 + r2 * (-1.0 / 87178291200)) +
                          (1.0 / 20922789888000 + r2 * (-1.0 / 6402373705728000)) * r4;
    const double s = r + r * r2 * (s_low + s_high * r8);
    const double c = 1 - (0.5 * r2 - r4 * (c_low + c_high * r8));
    switch (static_cast<std::int64_t>(n) & 3) {
        case 0: return {s, c};
        case 1: return {c, -s};
        case 2: return {-s, -c};
        default: return {-c, s};
    }
}
[[nodiscard]] inline double sin(double x) noexcept {
    return sin_cos(x).sin;
}
[[nodiscard]] inline double cos(double x) noexcept {
    return sin_cos(x).cos;
}
[[nodiscard]] inline double tan(double x) noexcept {
    const SinCos both = sin_cos(x);
    return both.sin / both.cos;
}

/// Angle of the point (x, y) from the x axis, (-pi, pi]; 0 for the origin and for NaN. The sign of
/// a zero is ignored.
[[nodiscard]] inline double atan2(double y, double x) noexcept {
    const double ax = std::fabs(x);
    const double ay = std::fabs(y);
    if (!(ax + ay > 0) || !(ax + ay < 1e300))
        return 0;
    const bool steep = ay > ax;
    double z = steep ? ax / ay : ay / ax;  // [0, 1]
    // Halve the angle three times: tan(a / 2) = t / (1 + sqrt(1 + t^2)). Then z <= tan(pi / 32),
    // and nine terms of the series suffice.
    for (int i = 0; i < 3; ++i)
        z = z / (1 + std::sqrt(1 + z * z));
    const double z2 = z * z;
    double sum = 0;
    for (int i = 17; i >= 3; i -= 2)
        sum = (1.0 / i - sum) * z2;
    double angle = 8 * (z - z * sum);
    if (steep)
        angle = kPi / 2 - angle;
    if (x < 0)
        angle = kPi - angle;
    return y < 0 ? -angle : angle;
}
/// [0, pi]; x is clamped to [-1, 1].
[[nodiscard]] inline double acos(double x) noexcept {
    if (!(x < 1))
        return 0;
    if (!(x > -1))
        return kPi;
    return atan2(std::sqrt((1 - x) * (1 + x)), x);
}
/// [-pi / 2, pi / 2]; x is clamped to [-1, 1].
[[nodiscard]] inline double asin(double x) noexcept {
    if (!(x > -1 && x < 1))
        return x >= 1 ? kPi / 2 : x <= -1 ? -kPi / 2 : 0;
    return atan2(x, std::sqrt((1 - x) * (1 + x)));
}

}  // namespace terravox::det
