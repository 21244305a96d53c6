#include "raytracer/analyse/report/map_sheet.hpp"

#include <cpl_string.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "common/util/text.hpp"
#include "common/util/utf8.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
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

// Lengths in units of the sheet's view box: the longer side of a map has kMap, letters have 14.
constexpr double kMap = 900;
constexpr double kNarrowest = 600;  // of what is printed
constexpr double kMargin = 18;
constexpr double kLine = 22;
constexpr double kBaseline = 15;  // below the top of a line
constexpr double kWidest = 8;     // what a byte of text takes on average, whatever the font

/// What is printed between the margins, from the left margin and its own top on.
struct Part {
    std::string svg;
    double height = 0;
};

std::string css(map::Rgba8 colour) {
    return fmt::format("#{:02x}{:02x}{:02x}", colour.r, colour.g, colour.b);
}

/// @param anchor which part of the text stands at x: start, middle or end
std::string words(double x, double y, std::string_view anchor, std::string_view text) {
    return fmt::format(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="{}">{}</text>)", x,
                       y + kBaseline, anchor, util::escaped_markup(util::printable(text)));
}

Part map_part(const MapPicture& picture) {
    const std::string png = map::to_png(picture.pixels, picture.width, picture.height);
    const std::unique_ptr<char, decltype(&VSIFree)> letters(
        CPLBase64Encode(static_cast<int>(png.size()), reinterpret_cast<const GByte*>(png.data())),
        &VSIFree);
    const double unit = kMap / std::max(picture.width, picture.height);
    const double height = picture.height * unit;
    return {
        fmt::format(R"(<image width="{:.1f}" height="{:.1f}" href="data:image/png;base64,{}"/>)",
                    picture.width * unit, height, letters.get()),
        height + kMargin / 2};
}

/// A bar of a round length, up to a third of the map, and an arrow to the north.
Part lengths_part(const MapPicture& picture, double cell_m, double width) {
    constexpr int kShare = 3;
    constexpr double kKilometre_m = 1000;
    const double unit_m =
        cell_m * picture.cells_per_px * std::max(picture.width, picture.height) / kMap;
    const double map_m = cell_m * picture.cells_per_px * picture.width;
    const double length_m = round_step(map_m / kShare, 2);
    const double length = length_m / unit_m;
    const bool is_far = length_m >= kKilometre_m;
    const double shown = is_far ? length_m / kKilometre_m : length_m;
    return {fmt::format(R"(<path d="M0 4v10H{:.1f}v-10" fill="none" stroke="#222" stroke-width="2"/>
<path d="M{:.1f} 1l6 17-6-5-6 5z"/>)",
                        length, width - 6) +
                words(length + kMargin / 2, 0, "start",
                      number_text(shown, round_step(shown, 1)) + (is_far ? " km" : " m")) +
                words(width - kMargin, 0, "end", "N"),
            kLine + kMargin / 2};
}

/// The scale of colours with its ticks; above it bars of how much area has which values: as many as
/// bins, four taken together, within the scale.
Part scale_part(const BandFacts& band, double width) {
    constexpr double kBars = 100;
    constexpr double kStrip = 12;
    constexpr int kStops = 4;  // colours of ramps are given at quarters or more rarely
    constexpr std::size_t kTogether = 4;
    const BandStatistics& s = band.statistics;
    const Legend& legend = *band.legend;
    std::array<std::uint64_t, BandStatistics::kBins / kTogether> bars{};
    for (std::size_t i = 0; i < s.bins.size(); ++i)
        bars[i / kTogether] += s.bins[i];
    const auto highest = static_cast<double>(*std::ranges::max_element(bars));
    const auto find_x = [&](std::size_t bar) {
        const double value = s.min + (s.max - s.min) * static_cast<double>(bar) / bars.size();
        return std::clamp((value - legend.low) / (legend.high - legend.low), 0.0, 1.0) * width;
    };
    std::string out =
        fmt::format(R"(<linearGradient id="ramp-{}" gradientUnits="userSpaceOnUse" x2="{:.1f}">)",
                    band.band.name, width);
    for (int i = 0; i <= kStops; ++i)
        out += fmt::format(R"(<stop offset="{}%" stop-color="{}"/>)", 100 * i / kStops,
                           css(colour_at(legend.ramp, static_cast<double>(i) / kStops)));
    out += fmt::format(R"(</linearGradient>
<path fill='url(#ramp-{})' stroke="#888" stroke-width=".5" d="M0 {}h{:.1f}v{}H0z)",
                       band.band.name, kBars, width, kStrip);
    for (std::size_t i = 0; i < bars.size(); ++i)
        if (const double left = find_x(i); bars[i] > 0 && left < width && find_x(i + 1) > 0) {
            // Where all values are alike, the one bar has no width of its own.
            out += fmt::format("M{:.1f} {}V{:.1f}H{:.1f}V{}z", left, kBars,
                               kBars * (1 - static_cast<double>(bars[i]) / highest),
                               std::max(find_x(i + 1), left + 1), kBars);
        }
    out += "\"/>";
    for (const Tick& tick : legend.ticks) {
        const char* anchor = tick.share < 0.02 ? "start" : tick.share > 0.98 ? "end" : "middle";
        out += words(tick.share * width, kBars + kStrip, anchor, tick.label);
    }
    return {out, kBars + kStrip + kLine};
}

/// Categories in two columns.
Part entries_part(const BandFacts& band, double cell_m, double width) {
    const double column = (width - kMargin) / 2;
    const std::vector<LegendEntry>& entries = band.legend->entries;
    std::string out;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const LegendEntry& entry = entries[i];
        const double x = static_cast<double>(i % 2) * (column + kMargin);
        const double y = static_cast<double>(i / 2) * kLine;
        out +=
            fmt::format(R"(<rect x="{:.1f}" y="{:.1f}" width="16" height="16" fill="{}"/>)", x,
                        y + 2, css(entry.colour)) +
            words(x + kLine, y, "start", entry.name) +
            words(x + column, y, "end",
                  number_text(100 * entry.share, kPercentStep) + " %, " +
                      area_text(entry.share * static_cast<double>(band.statistics.cells), cell_m));
    }
    return {out, static_cast<double>((entries.size() + 1) / 2) * kLine};
}

}  // namespace

std::string map_sheet(const MapPicture& picture, const BandFacts& band, double cell_m,
                      std::string_view credit, bool is_file) {
    const double width =
        std::max(kNarrowest, kMap * picture.width / std::max(picture.width, picture.height));
    const std::string title(band.band.style.title);
    const std::string unit(band.band.unit);
    std::string body;
    double y = kMargin / 2;
    const auto put = [&](const Part& part) {
        body += fmt::format("<g transform=\"translate({} {:.1f})\">{}</g>\n", kMargin, y, part.svg);
        y += part.height;
    };
    put({words(0, 0, "start", unit.empty() ? title : title + ", " + unit), kLine + 4});
    put(map_part(picture));
    put(lengths_part(picture, cell_m, width));
    put(has_categories(band.legend->ramp) ? entries_part(band, cell_m, width)
                                          : scale_part(band, width));
    const auto fits = [&](const std::string& line) {
        return static_cast<double>(line.size()) * kWidest <= width;
    };
    for (const std::string& line : util::broken_lines(credit, fits))
        put({words(0, 0, "start", line), kLine});
    constexpr std::string_view kForm =
        R"(<svg{} viewBox="0 0 {:.1f} {:.1f}" font-family="sans-serif" font-size="14" fill="#222">
<rect width="100%" height="100%" fill="#fff"/>
{}</svg>
)";
    return fmt::format(kForm, is_file ? R"( xmlns="http://www.w3.org/2000/svg")" : "",
                       width + 2 * kMargin, y + kMargin / 2, body);
}

}  // namespace terravox::analyse
