#pragma once

#include <vector>

#include "raytracer/core/ray.hpp"

namespace terravox::sky {

struct SkySample {
    core::Vec3 direction;  ///< of unit length, y >= 0
    double pdf = 0;        ///< 1 / sr
};

/// Chooses directions of the upper hemisphere, bright ones more often: constant over each of 64 x
/// 32 cells of equal solid angle. Immutable, thread-safe.
class SkySampler {
public:
    static constexpr int kColumns = 64, kRows = 32;  ///< of azimuth; of the elevation's sine

    /// @param luminance of the cells, row by row from the horizon up, each from azimuth 0 (east)
    /// over south; >= 0
    explicit SkySampler(const std::vector<double>& luminance);

    [[nodiscard]] SkySample sample(double u, double v) const noexcept;  ///< @param u, v [0, 1)
    [[nodiscard]] double pdf(core::Vec3 direction)
        const noexcept;  ///< @param direction of unit length; 0 below the horizon

private:
    std::vector<double> m_row_ends;   ///< share of all rows up to and with each
    std::vector<double> m_cell_ends;  ///< in each row
    std::vector<double> m_pdf;        ///< of each cell, 1 / sr
};

}  // namespace terravox::sky
