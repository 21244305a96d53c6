#include "tests/bench/accuracy/errors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terravox::bench {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

double ratio(std::size_t part, std::size_t whole) noexcept {
    return whole == 0 ? kUnknown : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

double Errors::rmse() const noexcept {
    double sum = 0;
    for (const double v : m_values)
        sum += v * v;
    return m_values.empty() ? kUnknown : std::sqrt(sum / static_cast<double>(m_values.size()));
}

double Errors::bias() const noexcept {
    double sum = 0;
    for (const double v : m_values)
        sum += v;
    return m_values.empty() ? kUnknown : sum / static_cast<double>(m_values.size());
}

double Errors::worst() const noexcept {
    double out = m_values.empty() ? kUnknown : 0;
    for (const double v : m_values)
        out = std::max(out, std::abs(v));
    return out;
}

double Errors::size_at(double share) const {
    if (m_values.empty())
        return kUnknown;
    std::vector<float> sizes;
    sizes.reserve(m_values.size());
    for (const float v : m_values)
        sizes.push_back(std::abs(v));
    const auto rank =
        static_cast<std::size_t>(std::ceil(share * static_cast<double>(sizes.size())));
    const auto at = sizes.begin() +
                    static_cast<std::ptrdiff_t>(std::clamp<std::size_t>(rank, 1, sizes.size()) - 1);
    std::nth_element(sizes.begin(), at, sizes.end());
    return *at;
}

double Share::value() const noexcept {
    return ratio(held, asked);
}
double Overlap::iou() const noexcept {
    return ratio(both, either);
}

}  // namespace terravox::bench
