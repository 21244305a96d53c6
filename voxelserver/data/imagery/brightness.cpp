#include "voxelserver/data/imagery/brightness.hpp"

#include <cmath>
#include <cstddef>

namespace terravox::imagery {

Brightness Brightness::of_bits(int bits) noexcept {
    return bits < 8 ? of_white(std::ldexp(1.0, bits) - 1) : Brightness{std::ldexp(1.0, 8 - bits)};
}

ValueRange find_range(std::vector<float> values, double greatest) {
    std::erase_if(values, [](float v) { return !std::isfinite(v) || v == 0; });
    const auto is_end = [&](float v) { return static_cast<double>(v) == greatest; };
    if (!std::all_of(values.begin(), values.end(), is_end))
        std::erase_if(values, is_end);
    if (values.empty())
        return {};
    const std::size_t few = values.size() / 1000;
    const auto nth = [&](std::size_t n) {
        const auto at = values.begin() + static_cast<std::ptrdiff_t>(n);
        std::nth_element(values.begin(), at, values.end());
        return static_cast<double>(*at);
    };
    return {std::min(nth(few), 0.0), std::max(nth(values.size() - 1 - few), 0.0)};
}

namespace {

Assumption assume_bits(int bits, bool is_doubtful) {
    return {Brightness::of_bits(bits), std::ldexp(1.0, bits) - 1, std::to_string(bits) + " bits",
            is_doubtful};
}

/// Of whole numbers, or of floating-point numbers that are none between 0 and 1.
Assumption assume_whole(double high) {
    constexpr double kReflectance = 10'000;  // parts of it, as of Sentinel-2
    for (const int bits : {8, 10, 11, 12})
        if (high < std::ldexp(1.0, bits))
            return assume_bits(bits, bits > 8);
    if (high <= kReflectance)
        return {Brightness::of_white(kReflectance), kReflectance, "reflectance in parts of 10000",
                true};
    for (const int bits : {14, 16})
        if (high < std::ldexp(1.0, bits))
            return assume_bits(bits, bits < 16);
    return {Brightness::of_white(high), high, "no known depth", true};
}

}  // namespace

Assumption assume_brightness(const ValueRange& range, bool whole_numbers) {
    constexpr double kDark = 64;  // 8-bit brightness that no photograph of a day stays below
    Assumption out;
    if (whole_numbers || range.high >= 256) {
        out = assume_whole(range.high);
    } else if (range.high <= kMostReflectance) {
        out = {Brightness::of_white(1), 1, "parts of 1", range.high > 1.5};
    } else {
        out = {{1, 0.5}, 255, "0 to 255", range.high < kDark};
    }
    constexpr double kBelowBlack = 0.1;  // noise around black is less
    if (range.low < -kBelowBlack * out.white)
        out.is_doubtful = true;
    return out;
}

}  // namespace terravox::imagery
