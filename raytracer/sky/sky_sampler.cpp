#include "raytracer/sky/sky_sampler.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"

namespace terravox::sky {
namespace {

constexpr double kCell_sr = 2 * det::kPi / (SkySampler::kColumns * SkySampler::kRows);
// Share that every direction gets: a cell's mean may be dark where a corner of it is not.
constexpr double kEven = 0.05;

/// @return which of the ends a number falls before; `u` becomes its place in that cell, [0, 1]
int find(const double* ends, int count, double& u) noexcept {
    const int i =
        std::min(static_cast<int>(std::upper_bound(ends, ends + count, u) - ends), count - 1);
    const double low = i > 0 ? ends[i - 1] : 0;
    const double size = ends[i] - low;
    u = size > 0 ? std::clamp((u - low) / size, 0.0, 1.0) : 0.5;
    return i;
}

}  // namespace

SkySampler::SkySampler(const std::vector<double>& luminance)
    : m_row_ends(kRows), m_cell_ends(kRows * kColumns), m_pdf(kRows * kColumns) {
    double all = 0;
    for (const double l : luminance)
        all += l;
    const double cells = kRows * kColumns;
    double rows = 0;
    for (std::size_t row = 0; row < kRows; ++row) {
        double sum = 0;
        for (std::size_t column = 0; column < kColumns; ++column) {
            const std::size_t cell = row * kColumns + column;
            const double share =
                all > 0 ? (1 - kEven) * luminance[cell] / all + kEven / cells : 1 / cells;
            m_pdf[cell] = share / kCell_sr;
            m_cell_ends[cell] = sum += share;
        }
        for (std::size_t column = 0; column < kColumns; ++column)
            m_cell_ends[row * kColumns + column] /= sum;
        m_row_ends[row] = rows += sum;
    }
    for (double& end : m_row_ends)
        end /= rows;
}

SkySample SkySampler::sample(double u, double v) const noexcept {
    const int row = find(m_row_ends.data(), kRows, v);
    const int column = find(&m_cell_ends[static_cast<std::size_t>(row * kColumns)], kColumns, u);
    const double y = (row + v) / kRows;
    const double flat = std::sqrt(std::max(0.0, 1 - y * y));
    const auto turn = det::sin_cos(2 * det::kPi * (column + u) / kColumns);
    return {{flat * turn.cos, y, flat * turn.sin},
            m_pdf[static_cast<std::size_t>(row * kColumns + column)]};
}

double SkySampler::pdf(core::Vec3 d) const noexcept {
    if (!(d.y >= 0))
        return 0;
    const int row = std::min(static_cast<int>(std::min(d.y, 1.0) * kRows), kRows - 1);
    const double turn = det::atan2(d.z, d.x) / (2 * det::kPi);
    const int column =
        std::clamp(static_cast<int>((turn < 0 ? turn + 1 : turn) * kColumns), 0, kColumns - 1);
    return m_pdf[static_cast<std::size_t>(row * kColumns + column)];
}

}  // namespace terravox::sky
