#include "raytracer/core/output/credit_line.hpp"

#include <algorithm>

#include "raytracer/core/output/small_font.hpp"

namespace terravox::output {
namespace {

constexpr int kLineRows = static_cast<int>(Glyph::kRows);
constexpr int kGap = 1;
// Of the picture's height to a row of a letter's pixels; and larger letters are not small any more.
constexpr int kRowsInPicture = 60 * kLineRows;
constexpr int kMaxScale = 12;

int width_of(std::u32string_view line) noexcept {
    int width = 0;
    for (const char32_t c : line)
        width += glyph_of(c).width + kGap;
    return std::max(width - kGap, 0);
}

/// Lines no wider than `max_width`, broken at spaces, or within a word that is too long for one.
std::vector<std::u32string> broken(const std::u32string& text, int max_width) {
    std::vector<std::u32string> lines(1);
    std::size_t last_space = std::u32string::npos;
    for (const char32_t c : text) {
        std::u32string& line = lines.back();
        if (line.empty() && c == U' ')
            continue;
        line.push_back(c);
        if (c == U' ')
            last_space = line.size() - 1;
        if (width_of(line) <= max_width || line.size() == 1)
            continue;
        const std::size_t cut = last_space == std::u32string::npos ? line.size() - 1 : last_space;
        std::u32string rest = line.substr(line[cut] == U' ' ? cut + 1 : cut);
        line.resize(cut);
        lines.push_back(std::move(rest));
        last_space = std::u32string::npos;
    }
    if (lines.back().empty())
        lines.pop_back();
    return lines;
}

/// Means over 2 r + 1 values of each row (stride 1) or column, of `lines` lines of `count` values;
/// 0 beyond.
void blur(std::vector<float>& values, std::size_t lines, std::size_t line_stride, std::size_t count,
          std::size_t stride, std::size_t r) {
    std::vector<float> line(count + 2 * r + 1);
    for (std::size_t l = 0; l < lines; ++l) {
        std::fill(line.begin(), line.end(), 0.0f);
        for (std::size_t i = 0; i < count; ++i)
            line[i + r] = values[l * line_stride + i * stride];
        float sum = 0;
        for (std::size_t i = 0; i < 2 * r; ++i)
            sum += line[i];
        for (std::size_t i = 0; i < count; ++i) {
            sum += line[i + 2 * r];
            values[l * line_stride + i * stride] = sum / static_cast<float>(2 * r + 1);
            sum -= line[i];
        }
    }
}

}  // namespace

CreditLine::CreditLine(std::string_view text, int width_px, int height_px) {
    std::u32string letters = letters_of(text);
    std::replace_if(letters.begin(), letters.end(), [](char32_t c) { return c < U' '; }, U' ');
    if (letters.find_first_not_of(U' ') == std::u32string::npos)
        return;
    int scale = std::clamp((height_px + kRowsInPicture / 2) / kRowsInPicture, 1, kMaxScale);
    // Room for the edge around the letters, and the same again to the picture's border.
    constexpr int kEdge = 3;
    while (scale > 1 && (width_of(letters) + 4 * kEdge) * scale > width_px)
        --scale;
    const int max_width = width_px / scale - 4 * kEdge;
    if (max_width < 8)
        return;  // not even one letter
    std::vector<std::u32string> lines = broken(letters, max_width);
    const int fit = (height_px / scale - 4 * kEdge) / kLineRows;
    if (fit < static_cast<int>(lines.size()))
        lines.resize(static_cast<std::size_t>(std::max(fit, 0)));
    if (lines.empty())
        return;

    int widest = 0;
    for (const auto& line : lines)
        widest = std::max(widest, width_of(line));
    m_width = (widest + 2 * kEdge) * scale;
    m_height = (static_cast<int>(lines.size()) * kLineRows + 2 * kEdge) * scale;
    m_x0 = width_px - m_width - kEdge * scale;
    m_y0 = height_px - m_height - kEdge * scale;
    m_inks.resize(static_cast<std::size_t>(m_width) * static_cast<std::size_t>(m_height));
    std::vector<float> edge(m_inks.size());
    int top = m_y0 + kEdge * scale;
    for (const auto& line : lines) {
        int left = m_x0 + m_width - (kEdge + width_of(line)) * scale;
        for (const char32_t c : line) {
            const Glyph glyph = glyph_of(c);
            for (int y = 0; y < kLineRows * scale; ++y)
                for (int x = 0; x < glyph.width * scale; ++x)
                    if (glyph.rows[static_cast<std::size_t>(y / scale)] >>
                            (glyph.width - 1 - x / scale) &
                        1) {
                        m_inks[index(left + x, top + y)].light = 255;
                        edge[index(left + x, top + y)] = 1;
                    }
            left += (glyph.width + kGap) * scale;
        }
        top += kLineRows * scale;
    }
    const auto columns = static_cast<std::size_t>(m_width);
    const auto rows = static_cast<std::size_t>(m_height);
    const auto radius = static_cast<std::size_t>(scale);
    for (int pass = 0; pass < 2; ++pass) {
        blur(edge, rows, columns, columns, 1, radius);
        blur(edge, columns, 1, rows, columns, radius);
    }
    constexpr float kStrength = 2.4f;
    constexpr float kDarkest = 165;
    for (std::size_t i = 0; i < edge.size(); ++i)
        m_inks[i].dark = static_cast<std::uint8_t>(std::min(edge[i] * kStrength, 1.0f) * kDarkest);
}

}  // namespace terravox::output
