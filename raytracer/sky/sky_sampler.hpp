#pragma once

#include <vector>

#include "raytracer/core/ray.hpp"

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
    std::vector<double> m_row_ends;   ///< cumulative share of the rows, up to and including each
    std::vector<double> m_cell_ends;  ///< cumulative share within each row
    std::vector<double> m_pdf;        ///< of each cell, 1 / sr
};

}  // namespace terravox::sky
