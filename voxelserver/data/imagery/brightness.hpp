#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace terravox::imagery {

/// Parts of 1 that a surface reflects, at most: a bright roof or cloud reflects more than a white
/// sheet does.
inline constexpr double kMostReflectance = 2;

/// Which values of an image are black and white: the brightness of a value is floor(value * factor
/// + add), cut to [0, 255].
struct Brightness {
    double factor = 1;
    double add = 0;
    [[nodiscard]] std::uint8_t of(double value) const noexcept {
        const double v = value * factor + add;
        return v > 0 ? static_cast<std::uint8_t>(std::min(v, 255.0)) : 0;  // 0: no number, too
    }
    /// Of whole numbers of so many bits: their upper 8; of fewer bits, all of their range.
    /// @param bits [1, 32]
    [[nodiscard]] static Brightness of_bits(int bits) noexcept;
    /// 0 is black.
    [[nodiscard]] static Brightness of_white(double white) noexcept { return {255 / white, 0.5}; }
    /// Of values that are brightness = value * scale + offset, as of a GDAL band.
    [[nodiscard]] Brightness of_scaled(double scale, double offset) const noexcept {
        return {factor * scale, factor * offset + add};
    }
    [[nodiscard]] Brightness inverted() const noexcept { return {-factor, 255 + add}; }
};

/// The values of an image apart from a thousandth at each end, and from 0, which is often used for
/// no data. Without any but 0 both are 0.
struct ValueRange {
    double low = 0;
    double high = 0;
    void add(const ValueRange& other) noexcept {
        low = std::min(low, other.low);
        high = std::max(high, other.high);
    }
};
/// @param values  in any order; what is not finite, and 0, is left out
/// @param greatest of their type: left out too, unless there is nothing else, since it is used for
/// no data and for what was too bright
[[nodiscard]] ValueRange find_range(std::vector<float> values, double greatest);

/// What values are taken for that no metadata explain.
struct Assumption {
    Brightness brightness;
    double white = 255;        ///< the brightest value
    std::string what;          ///< "12 bits"
    bool is_doubtful = false;  ///< other readings are about as likely
};
/// @param whole_numbers of integers, else of floating-point numbers
[[nodiscard]] Assumption assume_brightness(const ValueRange& range, bool whole_numbers);

}  // namespace terravox::imagery
