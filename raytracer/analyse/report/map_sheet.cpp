#include "raytracer/analyse/report/map_sheet.hpp"

#include <algorithm>
#include <cmath>

#include "raytracer/core/output/lettering.hpp"
#include "voxelserver/serve/map/pixels.hpp"

namespace terravox::analyse {
namespace {

constexpr map::Rgba8 kNothing{218, 218, 218, 255};
constexpr map::Rgba8 kHole{255, 0, 204, 255};

struct Size {
    int width = 0;
    int height = 0;
};

Size drawn_size(const CellFile& cells, int most_px) {
    const int longer = std::max(cells.columns(), cells.rows());
    if (longer <= most_px) {
        const int times = most_px / longer;
        return {cells.columns() * times, cells.rows() * times};
    }
    const double share = static_cast<double>(most_px) / longer;
    const auto scaled = [&](int side) {
        return std::max(1, static_cast<int>(std::lround(side * share)));
    };
    return {scaled(cells.columns()), scaled(cells.rows())};
}

std::vector<float> read_at(CellFile& cells, std::string_view band, Size size,
                           GDALRIOResampleAlg how) {
    std::vector<float> out(static_cast<std::size_t>(size.width) *
                           static_cast<std::size_t>(size.height));
    const output::GdalWatch watch("draw a band of the raster");
    GDALRasterIOExtraArg extra;
    INIT_RASTERIO_EXTRA_ARG(extra);
    extra.eResampleAlg = how;
    watch.check(GDALRasterIOEx(cells.find_band(band), GF_Read, 0, 0, cells.columns(), cells.rows(),
                               out.data(), size.width, size.height, GDT_Float32, 0, 0,
                               &extra) == CE_None);
    return out;
}

}  // namespace

MapPicture draw_band(CellFile& cells, std::string_view band, const Legend& legend, int most_px) {
    const Size size = drawn_size(cells, most_px);
    const bool is_smaller = size.width < cells.columns();
    // The mean of 359 and 1 degrees is none.
    const bool has_means =
        is_smaller && !has_categories(legend.ramp) && legend.ramp != Ramp::kAround;
    const auto values =
        read_at(cells, band, size, has_means ? GRIORA_Average : GRIORA_NearestNeighbour);
    const auto holes =
        read_at(cells, kHoleBand.name, size, is_smaller ? GRIORA_Average : GRIORA_NearestNeighbour);
    MapPicture out;
    out.width = size.width;
    out.height = size.height;
    out.cells_per_px = static_cast<double>(cells.columns()) / size.width;
    out.pixels.reserve(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (holes[i] > 0)
            out.pixels.push_back(kHole);
        else if (values[i] != core::kNoData)
            out.pixels.push_back(legend.to_colour(static_cast<double>(values[i])));
        else
            out.pixels.push_back(kNothing);
    }
    return out;
}

namespace {

constexpr map::Rgba8 kPaper{255, 255, 255, 255};
constexpr map::Rgba8 kInk{34, 34, 34, 255};
constexpr int kGlyphRows = static_cast<int>(output::Glyph::kRows);
constexpr int kGap = 1;          // between letters
constexpr int kNarrowest = 360;  // of what is printed, at a scale of 1
constexpr int kMostEntries = 12;
constexpr int kPxPerTextScale = 350;
constexpr int kMaxTextScale = 3;

/// Pixels to draw on, and a pen with a text size.
class Sheet {
public:
    /// @param scale pixels of a letter's pixel
    Sheet(int width, int height, int scale)
        : m_width(width),
          m_height(height),
          m_scale(scale),
          m_pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), kPaper) {}

    void fill(int x0, int y0, int width, int height, map::Rgba8 colour) {
        for (int y = std::max(y0, 0); y < std::min(y0 + height, m_height); ++y)
            for (int x = std::max(x0, 0); x < std::min(x0 + width, m_width); ++x)
                at(x, y) = colour;
    }

    /// @param x0 of the left edge; what does not fit to the right is cut off
    void write(int x0, int y0, std::string_view text) {
        int x = x0;
        for (const char32_t letter : output::to_letters(text)) {
            const output::Glyph glyph = output::find_glyph(letter);
            if (x + glyph.width * m_scale > m_width)
                return;
            draw(glyph, x, y0);
            x += (glyph.width + kGap) * m_scale;
        }
    }

    [[nodiscard]] int measure_width(std::string_view text) const {
        int width = 0;
        for (const char32_t letter : output::to_letters(text))
            width += output::find_glyph(letter).width + kGap;
        return width * m_scale;
    }

    void put(const MapPicture& picture, int x0, int y0) {
        for (int y = 0; y < picture.height; ++y)
            std::copy_n(picture.pixels.begin() + static_cast<std::ptrdiff_t>(y) * picture.width,
                        picture.width, &at(x0, y0 + y));
    }

    [[nodiscard]] std::string png() const { return map::to_png(m_pixels, m_width, m_height); }

private:
    [[nodiscard]] map::Rgba8& at(int x, int y) {
        return m_pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(m_width) +
                        static_cast<std::size_t>(x)];
    }

    void draw(const output::Glyph& glyph, int x0, int y0) {
        for (int row = 0; row < kGlyphRows; ++row)
            for (int column = 0; column < glyph.width; ++column) {
                const int bit = glyph.width - 1 - column;
                if ((glyph.rows[static_cast<std::size_t>(row)] >> bit & 1) != 0)
                    fill(x0 + column * m_scale, y0 + row * m_scale, m_scale, m_scale, kInk);
            }
    }

    const int m_width;
    const int m_height;
    const int m_scale;
    std::vector<map::Rgba8> m_pixels;
};

/// Lengths of a sheet, in pixels.
struct Layout {
    explicit Layout(const MapPicture& picture)
        : scale(std::clamp(std::max(picture.width, picture.height) / kPxPerTextScale, 1,
                           kMaxTextScale)),
          line((kGlyphRows + 4) * scale),
          margin(12 * scale),
          width(std::max(picture.width, kNarrowest * scale)) {}
    int scale;
    int line;    ///< height of a line of text
    int margin;  ///< around everything
    int width;   ///< of what is printed, without margins
};

std::size_t shown_entries(const Legend& legend) noexcept {
    return std::min<std::size_t>(legend.entries.size(), kMostEntries);
}

int legend_height(const Legend& legend, const Layout& layout) {
    if (!has_categories(legend.ramp))
        return 2 * layout.line;
    return static_cast<int>((shown_entries(legend) + 1) / 2) * layout.line;
}

void draw_ramp(Sheet& sheet, const Legend& legend, const Layout& layout, int y) {
    for (int x = 0; x < layout.width; ++x) {
        const double share = (x + 0.5) / layout.width;
        sheet.fill(layout.margin + x, y, 1, layout.line - 4 * layout.scale,
                   colour_at(legend.ramp, share));
    }
    for (const Tick& tick : legend.ticks) {
        const int at = layout.margin + static_cast<int>(tick.share * (layout.width - 1));
        const int label = sheet.measure_width(tick.label);
        sheet.fill(at, y + layout.line - 4 * layout.scale, layout.scale, 3 * layout.scale, kInk);
        const int left = std::clamp(at - label / 2, layout.margin,
                                    layout.margin + std::max(0, layout.width - label));
        sheet.write(left, y + layout.line, tick.label);
    }
}

void draw_entries(Sheet& sheet, const Legend& legend, const Layout& layout, int y) {
    for (std::size_t i = 0; i < shown_entries(legend); ++i) {
        const LegendEntry& entry = legend.entries[i];
        const int x = layout.margin + static_cast<int>(i % 2) * layout.width / 2;
        const int top = y + static_cast<int>(i / 2) * layout.line;
        sheet.fill(x, top, layout.line - 4 * layout.scale, layout.line - 4 * layout.scale,
                   entry.colour);
        sheet.write(x + layout.line, top,
                    entry.name + " " + number_text(100 * entry.share, kPercentStep) + " %");
    }
}

// A bar of a round length, up to a third of the map.
void draw_lengths(Sheet& sheet, const MapPicture& picture, const Layout& layout, double cell_m,
                  int y) {
    constexpr int kShare = 3;
    constexpr double kKilometre_m = 1000;
    const double px_m = cell_m * picture.cells_per_px;
    const double length_m = round_step(px_m * picture.width / kShare, 2);
    const int length_px = std::max(1, static_cast<int>(std::lround(length_m / px_m)));
    const bool is_far = length_m >= kKilometre_m;
    const double shown = is_far ? length_m / kKilometre_m : length_m;
    sheet.fill(layout.margin, y + layout.line / 2, length_px, 2 * layout.scale, kInk);
    sheet.write(layout.margin + length_px + layout.margin / 2, y,
                number_text(shown, round_step(shown, 1)) + (is_far ? " km" : " m"));
}

}  // namespace

std::string map_sheet(const MapPicture& picture, const Legend& legend, const SheetFacts& facts) {
    const Layout layout(picture);
    const int map_y = layout.margin + layout.line;
    const int legend_y = map_y + picture.height + layout.margin / 2;
    const int lengths_y = legend_y + legend_height(legend, layout) + layout.margin / 2;
    const int credit_y = lengths_y + layout.line;
    const int end = (facts.credit.empty() ? lengths_y : credit_y) + layout.line;
    Sheet sheet(layout.width + 2 * layout.margin, end + layout.margin / 2, layout.scale);
    sheet.write(layout.margin, layout.margin / 2,
                facts.unit.empty() ? facts.title : facts.title + ", " + facts.unit);
    sheet.put(picture, layout.margin, map_y);
    if (has_categories(legend.ramp))
        draw_entries(sheet, legend, layout, legend_y);
    else
        draw_ramp(sheet, legend, layout, legend_y);
    draw_lengths(sheet, picture, layout, facts.cell_m, lengths_y);
    sheet.write(layout.margin, credit_y, facts.credit);
    return sheet.png();
}

}  // namespace terravox::analyse
