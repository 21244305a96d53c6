#include "raytracer/core/sky/sky_sampler.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"

namespace terravox::sky {
namespace {

constexpr double kCell_sr = 2 * det::kPi / (SkySampler::kColumns * SkySampler::kRows);
// Share that every direction gets: a cell's mean may be dark where a corner of it is not.
constexpr double kEven = 0.05;
constexpr double kBelowOne = 0x1.fffffffffffffp-1;

}  // namespace

template <int kCount>
void SkySampler::Choice<kCount>::make_guide() noexcept {
    std::size_t first = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
        while (first + 1 < kCount && ends[first] <= static_cast<double>(i) / kCount)
            ++first;
        guide[i] = static_cast<std::uint8_t>(first);
    }
}

template <int kCount>
int SkySampler::Choice<kCount>::find(double& u) const noexcept {
    // The product of a power of two is exact, so the guide is never beyond the result.
    static_assert((kCount & (kCount - 1)) == 0);
    std::size_t i = guide[static_cast<std::size_t>(std::clamp(u, 0.0, kBelowOne) * kCount)];
    while (i + 1 < kCount && ends[i] <= u)
        ++i;
    const double low = i > 0 ? ends[i - 1] : 0;
    const double size = ends[i] - low;
    u = size > 0 ? std::clamp((u - low) / size, 0.0, 1.0) : 0.5;
    return static_cast<int>(i);
}

SkySampler::SkySampler(const std::vector<double>& luminance)
    : m_columns(kRows), m_pdf(kRows * kColumns) {
    double all = 0;
    for (const double l : luminance)
        all += l;
    const double cells = kRows * kColumns;
    double rows = 0;
    for (std::size_t row = 0; row < kRows; ++row) {
        auto& ends = m_columns[row].ends;
        double sum = 0;
        for (std::size_t column = 0; column < kColumns; ++column) {
            const std::size_t cell = row * kColumns + column;
            const double share =
                all > 0 ? (1 - kEven) * luminance[cell] / all + kEven / cells : 1 / cells;
            m_pdf[cell] = share / kCell_sr;
            ends[column] = sum += share;
        }
        for (double& end : ends)
            end /= sum;
        m_columns[row].make_guide();
        m_rows.ends[row] = rows += sum;
    }
    for (double& end : m_rows.ends)
        end /= rows;
    m_rows.make_guide();
}

SkySample SkySampler::sample(double u, double v) const noexcept {
    const int row = m_rows.find(v);
    const int column = m_columns[static_cast<std::size_t>(row)].find(u);
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
