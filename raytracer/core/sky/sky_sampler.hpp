#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raytracer/core/base/ray.hpp"

namespace terravox::sky {

struct SkySample {
    core::Vec3 direction;  ///< of unit length, y >= 0
    double pdf = 0;        ///< 1 / sr
};

/// Samples directions of the upper hemisphere, bright ones more often: the density is constant over
/// each of 64 x 32 cells of equal solid angle. Immutable, thread-safe.
class SkySampler {
public:
    static constexpr int kColumns = 64, kRows = 32;  ///< in azimuth; in the sine of the elevation

    /// @param luminance of the cells, row by row from the horizon up, each from azimuth 0 (east)
    /// over south; >= 0
    explicit SkySampler(const std::vector<double>& luminance);

    /// @param u, v [0, 1)
    [[nodiscard]] SkySample sample(double u, double v) const noexcept;
    /// @param direction of unit length
    /// @return density of sample(); 0 below the horizon
    [[nodiscard]] double pdf(core::Vec3 direction) const noexcept;

private:
    /// A choice of one of kCount by their shares. Ref: Chen, Asau, "On generating random variates
    /// from an empirical distribution", AIIE Transactions 6(2), 1974 (the guide table).
    template <int kCount>
    struct Choice {
        static_assert(kCount <= 256);
        std::array<double, kCount> ends{};  ///< sum of the shares up to and including each; last: 1
        /// The first whose end lies beyond i / kCount: where the search for such a number begins.
        std::array<std::uint8_t, kCount> guide{};

        void make_guide() noexcept;
        /// @return the first whose end lies beyond `u`, [0, 1); `u` becomes its place in that
        /// share, [0, 1]
        [[nodiscard]] int find(double& u) const noexcept;
    };
    Choice<kRows> m_rows;
    std::vector<Choice<kColumns>> m_columns;  ///< of each row
    std::vector<double> m_pdf;                ///< of each cell, 1 / sr
};

}  // namespace terravox::sky
