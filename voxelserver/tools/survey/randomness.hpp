#pragma once

#include <cstdint>

#include "common/util/mix.hpp"

namespace terravox::survey {

/// A hash of a seed and any number of integers (coordinates, counters); the order of the integers
/// matters.
template <class... Integers>
[[nodiscard]] constexpr std::uint64_t compute_hash(std::uint64_t seed,
                                                   Integers... values) noexcept {
    ((seed = util::mix(seed ^ (static_cast<std::uint64_t>(values) * 0xD6E8FEB86659FD93ULL))), ...);
    return seed;
}

/// Random numbers as a function of a key and of how many were drawn: no state is shared between two
/// keys, so work can be divided anywhere. Implemented here because the distributions of <random>
/// differ between standard libraries.
class Random {
public:
    explicit constexpr Random(std::uint64_t key) noexcept : m_state(key) {}
    constexpr std::uint64_t next() noexcept { return util::mix(m_state += 0xA0761D6478BD642FULL); }
    /// [0, 1)
    constexpr double unit() noexcept { return static_cast<double>(next() >> 11) * 0x1p-53; }
    constexpr double range(double low, double high) noexcept { return low + (high - low) * unit(); }
    constexpr bool chance(double probability) noexcept { return unit() < probability; }
    /// Mean 0, standard deviation 1, within +-3.5: the sum of four uniform numbers (Irwin-Hall),
    /// which needs no logarithm.
    constexpr double normal() noexcept {
        const std::uint64_t bits = next();
        const std::uint64_t sum =
            (bits & 0xFFFF) + ((bits >> 16) & 0xFFFF) + ((bits >> 32) & 0xFFFF) + (bits >> 48);
        return (static_cast<double>(sum) / 65536.0 - 2.0) * 1.7320508075688772;
    }

private:
    std::uint64_t m_state;
};

/// Smooth noise of one variable, about [-1, 1], features one unit wide. A function of seed and
/// place only.
[[nodiscard]] double noise_1d(std::uint64_t seed, double x) noexcept;

/// Gradient noise of two variables, about [-1, 1], features one unit wide.
/// Ref: Perlin, "Improving Noise", SIGGRAPH 2002.
[[nodiscard]] double noise_2d(std::uint64_t seed, double x, double y) noexcept;

/// The sum of `octaves` noises, each twice as fine and half as high as the one before; about [-1,
/// 1].
[[nodiscard]] double fractal_2d(std::uint64_t seed, double x, double y, int octaves) noexcept;

}  // namespace terravox::survey
