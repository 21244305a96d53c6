#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "common/voxel/colour.hpp"

namespace terravox::output {

/// A line of text at the lower right of a picture, light with a dark edge, so that it is legible on
/// any background. Its height is about a sixtieth of the picture's; a text that is wider than the
/// picture is set smaller, then in several lines. The font is DejaVu Sans, which has the letters of
/// Europe's languages and many others. Safe to share between threads.
class CreditLine {
public:
    /// @param text UTF-8; empty: no line, and no font is read
    /// @throws Error without the font, and for letters that it lacks or that are written from right
    /// to left
    CreditLine(std::string_view text, int width_px, int height_px);

    /// Composites the text over the pixel at (x, y), counted from the upper left.
    /// @param display sRGB in [0, 1]
    [[nodiscard]] voxel::Colour over(voxel::Colour display, int x, int y) const noexcept {
        if (y < m_y0 || x < m_x0 || y >= m_y0 + m_height || x >= m_x0 + m_width)
            return display;
        const Ink ink = m_inks[index(x, y)];
        return voxel::mix(display * (1 - static_cast<float>(ink.dark) / 255),
                          {kLight, kLight, kLight}, static_cast<float>(ink.light) / 255);
    }
    [[nodiscard]] bool covers(int x, int y) const noexcept {
        return y >= m_y0 && x >= m_x0 && y < m_y0 + m_height && x < m_x0 + m_width &&
               (m_inks[index(x, y)].dark != 0 || m_inks[index(x, y)].light != 0);
    }

private:
    static constexpr float kLight = 0.96f;
    struct Ink {
        std::uint8_t light = 0;
        std::uint8_t dark = 0;
    };
    [[nodiscard]] std::size_t index(int x, int y) const noexcept {
        return static_cast<std::size_t>(y - m_y0) * static_cast<std::size_t>(m_width) +
               static_cast<std::size_t>(x - m_x0);
    }
    int m_x0 = 0;
    int m_y0 = 0;
    int m_width = 0;
    int m_height = 0;
    std::vector<Ink> m_inks;
};

/// Refuses what CreditLine would, before a picture is made.
/// @throws Error as CreditLine
void check_credit(std::string_view text);

}  // namespace terravox::output
