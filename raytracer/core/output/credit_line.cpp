#include "raytracer/core/output/credit_line.hpp"

#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_STROKER_H

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "common/util/utf8.hpp"

namespace terravox::output {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr double kFixedPoint = 64;  // FreeType's units in a pixel

void check_done(FT_Error error) {
    if (error != 0)
        throw util::Error("write the credit: the font {}: FreeType's error {}", kFont, error);
}

/// The face of the font. Outlines are not hinted: hints round them to whole pixels, by rules that
/// differ between versions of FreeType.
class Font {
public:
    Font() {
        FT_Library library = nullptr;
        check_done(FT_Init_FreeType(&library));
        m_library.reset(library);
        FT_Face face = nullptr;
        if (FT_New_Face(library, kFont, 0, &face) != 0)
            throw util::Error(
                "write the credit: the font {} cannot be read; it is in Debian's package "
                "fonts-dejavu-core",
                kFont);
        m_face.reset(face);
    }

    void set_size(int em_px) { check_done(FT_Set_Pixel_Sizes(m_face.get(), 0, em_px)); }

    /// The advance of a text, for a font whose em is 1.
    [[nodiscard]] double measure_width(std::string_view text) const {
        double width = 0;
        each_letter(text, [&](FT_UInt index) {
            check_done(FT_Load_Glyph(m_face.get(), index, FT_LOAD_NO_SCALE));
            width += static_cast<double>(m_face->glyph->metrics.horiAdvance);
        });
        return width / m_face->units_per_EM;
    }

    /// Calls `put` with the column, row and ink (0 to 255) of each pixel of a text.
    /// @param x, y where the base line begins
    /// @param edge_px by which letters are thicker than they are
    template <class Put>
    void draw(std::string_view text, double x, int y, double edge_px, const Put& put) const {
        FT_Stroker made = nullptr;
        check_done(FT_Stroker_New(m_library.get(), &made));
        const std::unique_ptr<FT_StrokerRec_, decltype(&FT_Stroker_Done)> stroker(made,
                                                                                  &FT_Stroker_Done);
        FT_Stroker_Set(made, std::lround(edge_px * kFixedPoint), FT_STROKER_LINECAP_ROUND,
                       FT_STROKER_LINEJOIN_ROUND, 0);
        FT_Vector pen{std::lround(x * kFixedPoint), 0};
        each_letter(text, [&](FT_UInt index) {
            check_done(FT_Load_Glyph(m_face.get(), index, FT_LOAD_NO_HINTING));
            FT_Glyph glyph = nullptr;
            check_done(FT_Get_Glyph(m_face->glyph, &glyph));
            if (edge_px > 0)
                check_done(FT_Glyph_StrokeBorder(&glyph, made, 0, 1));
            check_done(FT_Glyph_To_Bitmap(&glyph, FT_RENDER_MODE_NORMAL, &pen, 1));
            const auto* const drawn = reinterpret_cast<FT_BitmapGlyph>(glyph);
            const FT_Bitmap& map = drawn->bitmap;
            for (int row = 0; row < static_cast<int>(map.rows); ++row)
                for (int column = 0; column < static_cast<int>(map.width); ++column)
                    put(drawn->left + column, y - drawn->top + row,
                        map.buffer[row * map.pitch + column]);
            FT_Done_Glyph(glyph);
            pen.x += m_face->glyph->linearHoriAdvance / 1024;
        });
    }

private:
    template <class Take>
    void each_letter(std::string_view text, const Take& take) const {
        while (!text.empty()) {
            const util::Character letter = util::first_character(text);
            const FT_UInt index = FT_Get_Char_Index(m_face.get(), letter.code);
            // Hebrew, Arabic and their like: letters would come in the wrong order and shape.
            const bool is_from_right = (letter.code >= 0x590 && letter.code < 0x900) ||
                                       (letter.code >= 0xfb1d && letter.code < 0xff00);
            if (index == 0 || is_from_right)
                throw util::Error(
                    "write the credit: '{}' (U+{:04X}); allowed: letters of {} that are written "
                    "from left to right",
                    text.substr(0, letter.bytes), static_cast<std::uint32_t>(letter.code), kFont);
            take(index);
            text.remove_prefix(letter.bytes);
        }
    }

    std::unique_ptr<FT_LibraryRec_, decltype(&FT_Done_FreeType)> m_library{nullptr,
                                                                           &FT_Done_FreeType};
    std::unique_ptr<FT_FaceRec_, decltype(&FT_Done_Face)> m_face{nullptr, &FT_Done_Face};
};

/// On one line, with visible escapes of what is no text; empty where there is nothing to write.
std::string clean_credit(std::string_view text) {
    std::string out(text);
    std::ranges::replace_if(out, [](char c) { return c >= 0 && c < ' '; }, ' ');
    return out.find_first_not_of(' ') == std::string::npos ? "" : util::printable(out);
}

}  // namespace

void check_credit(std::string_view text) {
    if (const std::string words = clean_credit(text); !words.empty())
        (void)Font().measure_width(words);
}

CreditLine::CreditLine(std::string_view text, int width_px, int height_px) {
    const std::string words = clean_credit(text);
    if (words.empty())
        return;
    Font font;
    // Of the picture's height; and larger letters are not small any more.
    constexpr int kEmsInPicture = 64;
    constexpr int kSmallest_px = 11;
    constexpr int kLargest_px = 120;
    // Lengths in ems. Between the text and the border of the picture are two margins, in the inner
    // one the dark edge.
    constexpr double kMargin = 0.25;
    constexpr double kEdge = 0.14;
    constexpr double kLine = 1.2;
    constexpr double kAscent = 0.93;
    constexpr int kDarkest = 190;
    const double fitting = width_px / (font.measure_width(words) + 4 * kMargin);
    const int usual_px = std::clamp(height_px / kEmsInPicture, kSmallest_px, kLargest_px);
    const int em_px = std::clamp(static_cast<int>(fitting), kSmallest_px, usual_px);
    const double room = static_cast<double>(width_px) / em_px - 4 * kMargin;
    if (room < 1)
        return;  // not even one letter
    std::vector<std::string> lines = util::broken_lines(
        words, [&](const std::string& line) { return font.measure_width(line) <= room; });
    const auto rows =
        static_cast<int>((height_px / static_cast<double>(em_px) - 4 * kMargin) / kLine);
    if (rows < static_cast<int>(lines.size()))
        lines.resize(static_cast<std::size_t>(std::max(rows, 0)));
    if (lines.empty())
        return;

    double widest = 0;
    for (const std::string& line : lines)
        widest = std::max(widest, font.measure_width(line));
    const auto to_px = [&](double ems) { return static_cast<int>(std::ceil(ems * em_px)); };
    m_width = std::min(to_px(widest + 2 * kMargin), width_px);
    m_height = to_px(static_cast<double>(lines.size()) * kLine + 2 * kMargin);
    m_x0 = width_px - m_width - to_px(kMargin);
    m_y0 = height_px - m_height - to_px(kMargin);
    m_inks.resize(static_cast<std::size_t>(m_width) * static_cast<std::size_t>(m_height));
    font.set_size(em_px);
    int base = m_y0 + to_px(kMargin + kAscent);
    for (const std::string& line : lines) {
        const double left = m_x0 + m_width - (kMargin + font.measure_width(line)) * em_px;
        const auto draw = [&](double edge_px, std::uint8_t Ink::* layer, int strength) {
            font.draw(line, left, base, edge_px, [&](int x, int y, int ink) {
                if (x < m_x0 || y < m_y0 || x >= m_x0 + m_width || y >= m_y0 + m_height)
                    return;
                std::uint8_t& to = m_inks[index(x, y)].*layer;
                to = std::max(to, static_cast<std::uint8_t>(ink * strength / 255));
            });
        };
        draw(std::max(1.5, kEdge * em_px), &Ink::dark, kDarkest);
        draw(0, &Ink::light, 255);
        base += to_px(kLine);
    }
}

}  // namespace terravox::output
