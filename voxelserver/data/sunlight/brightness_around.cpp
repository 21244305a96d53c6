#include "voxelserver/data/sunlight/brightness_around.hpp"

#include <algorithm>
#include <functional>
#include <utility>

namespace terravox::sunlight {
namespace {

/// Combines `length` values that are `stride` apart, beginning at each.
template <class Combine>
std::vector<float> over_windows(std::vector<float> window, std::size_t stride, std::size_t length,
                                const Combine& combine) {
    std::vector<float> out(window.size(), 0.0F);
    std::vector<float> twice(window.size(), 0.0F);
    // `window` is over `size` values at each place. Beyond the end there is nothing.
    const auto combined = [&](const std::vector<float>& at, std::size_t by,
                              std::vector<float>& to) {
        for (std::size_t i = 0; i + by < window.size(); ++i)
            to[i] = combine(at[i], window[i + by]);
    };
    std::size_t done = 0;
    for (std::size_t size = 1; size <= length; size *= 2) {
        if ((length & size) != 0) {
            combined(out, done * stride, out);
            done += size;
        }
        combined(window, size * stride, twice);
        std::swap(window, twice);
    }
    return out;
}

}  // namespace

BrightnessAround::BrightnessAround(int width, int reach, const std::vector<BrightCell>& cells)
    : m_width(static_cast<std::size_t>(width)), m_reach(static_cast<std::size_t>(reach)) {
    Plane lit(cells.size(), 0.0F);
    Plane lit_count = lit;
    Plane shadow = lit;
    Plane shadow_count = lit;
    for (std::size_t i = 0; i < cells.size(); ++i)
        switch (cells[i].as) {
            case BrightCell::As::kLit:
                lit[i] = cells[i].light;
                lit_count[i] = 1;
                break;
            case BrightCell::As::kShadow:
                shadow[i] = cells[i].light;
                shadow_count[i] = 1;
                break;
            case BrightCell::As::kNothing: break;
        }
    const std::plus<float> sum;
    m_brightest_lit = over_squares(lit, [](float a, float b) { return std::max(a, b); });
    m_lit = over_squares(lit, sum);
    m_lit_count = over_squares(lit_count, sum);
    m_shadow = over_squares(shadow, sum);
    m_shadow_count = over_squares(shadow_count, sum);
}

BrightnessAround::Sums BrightnessAround::at(int x, int z) const noexcept {
    const std::size_t i =
        (static_cast<std::size_t>(z) - m_reach) * m_width + static_cast<std::size_t>(x) - m_reach;
    return {m_lit[i], m_brightest_lit[i], m_lit_count[i], m_shadow[i], m_shadow_count[i]};
}

template <class Combine>
BrightnessAround::Plane BrightnessAround::over_squares(const Plane& values,
                                                       const Combine& combine) const {
    const std::size_t side = 2 * m_reach + 1;
    return over_windows(over_windows(values, 1, side, combine), m_width, side, combine);
}

}  // namespace terravox::sunlight
