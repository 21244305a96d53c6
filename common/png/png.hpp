#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace terravox::png {

/// A text in a picture, such as its copyright.
struct Text {
    /// 1 to 79 printable ASCII characters, without spaces at its ends. The PNG specification
    /// (11.3.4) names some that other programs look for, such as "Software", "Description" and
    /// "Copyright".
    std::string keyword;
    std::string value;  ///< UTF-8, without bytes of 0
};

struct Shape {
    int width_px = 0;
    int height_px = 0;
    int channels = 4;  ///< 3: red, green, blue; 4: and straight alpha (not premultiplied)
};

/// The largest picture that encode() takes, bytes of its samples.
constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 31;

/// Encodes a PNG file of 8 bits per channel, sRGB. The same samples and texts give the same bytes
/// (no time is written).
/// @param samples the channels of a pixel one after the other, row by row from the top
/// @throws Error when the shape is empty or beyond kMaxBytes, when the number of samples is not
/// that of the shape, for a text that does not follow the rules above, or when libpng fails
[[nodiscard]] std::string encode(std::span<const std::uint8_t> samples, const Shape& shape,
                                 std::span<const Text> texts = {});

}  // namespace terravox::png
