#include "raytracer/analyse/report/html_report.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "raytracer/analyse/report/map_sheet.hpp"

namespace terravox::analyse {
namespace {

using util::escaped_markup;

constexpr int kMap_px = 900;  // of the longer side
constexpr int kPicture_px = 1600;

constexpr std::string_view kStyle = R"(
:root { color-scheme: light dark; font: 16px/1.5 system-ui, sans-serif; }
body { max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1, h2 { line-height: 1.2; font-weight: 600; }
h2 { margin-top: 2.5rem; }
figure { margin: 0; }
figure img { max-width: 100%; height: auto; background: #fff; image-rendering: auto; }
svg { width: 100%; height: auto; }
table { border-collapse: collapse; }
th, td { padding: .2rem .8rem .2rem 0; text-align: left; vertical-align: top; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
tr { border-bottom: 1px solid #8884; }
.warning { border-left: .3rem solid #c33; padding-left: .8rem; }
footer { margin-top: 3rem; font-size: .9rem; }
@media print { body { margin: 0; max-width: none; } h2, figure { break-inside: avoid; } }
)";

// Ref: RFC 4648.
std::string base64(std::string_view bytes) {
    constexpr std::string_view kLetters =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    constexpr std::size_t kGroup = 3;
    std::string out;
    out.reserve((bytes.size() + 2) / kGroup * 4);
    for (std::size_t i = 0; i < bytes.size(); i += kGroup) {
        const std::size_t count = std::min(kGroup, bytes.size() - i);
        std::uint32_t word = 0;
        for (std::size_t k = 0; k < kGroup; ++k)
            word = word << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k)
            out += k <= count ? kLetters[word >> (18 - 6 * k) & 63U] : '=';
    }
    return out;
}

std::string css(map::Rgba8 colour) {
    return "rgb(" + std::to_string(colour.r) + "," + std::to_string(colour.g) + "," +
           std::to_string(colour.b) + ")";
}

std::string area_text(double cells, double cell_m) {
    constexpr double kHectare_m2 = 10'000;
    constexpr double kSquareKilometre_m2 = 1'000'000;
    const double m2 = cells * cell_m * cell_m;
    if (m2 >= kSquareKilometre_m2)
        return number_text(m2 / kSquareKilometre_m2, 0.01) + " km\u00b2";
    if (m2 >= kHectare_m2)
        return number_text(m2 / kHectare_m2, 0.01) + " ha";
    return number_text(m2, 0.1) + " m\u00b2";
}

/// A band with what the report says of it.
struct BandFacts {
    RasterBand band;
    BandStatistics statistics;
    std::optional<Legend> legend;  ///< where it has a style and values
};

BandFacts collect_facts(CellFile& cells, const RasterBand& band, const std::stop_token& stop) {
    BandFacts out{band, measure_statistics(cells, band.name, stop), {}};
    if (band.style.title.empty() || out.statistics.cells == 0)
        return out;
    out.legend = has_categories(band.style.ramp)
                     ? categories_for(band.style, count_values(cells, band.name, stop))
                     : scale_for(band.style, out.statistics);
    return out;
}

std::string make_sheet(CellFile& cells, const BandFacts& band, const ReportFacts& facts,
                       int most_px) {
    const MapPicture picture = draw_band(cells, band.band.name, *band.legend, most_px);
    SheetFacts sheet;
    sheet.title = std::string(band.band.style.title);
    sheet.unit = std::string(band.band.unit);
    sheet.credit = facts.attribution;
    sheet.cell_m = facts.cell_m;
    return map_sheet(picture, *band.legend, sheet);
}

/// Bars of how much area has which values: as many as bins, four taken together, within the scale.
std::string chart(const BandFacts& band) {
    constexpr int kWidth = 900;
    constexpr int kHeight = 160;
    constexpr int kTogether = 4;
    constexpr int kText_px = 20;
    const BandStatistics& s = band.statistics;
    const Legend& legend = *band.legend;
    std::array<std::uint64_t, BandStatistics::kBins / kTogether> bars{};
    for (std::size_t i = 0; i < s.bins.size(); ++i)
        bars[i / kTogether] += s.bins[i];
    const auto highest = static_cast<double>(*std::max_element(bars.begin(), bars.end()));
    const double bar_width = (s.max - s.min) / static_cast<double>(bars.size());
    const auto find_x = [&](double value) {
        return kWidth * (value - legend.low) / (legend.high - legend.low);
    };
    std::string out = "<svg viewBox=\"0 0 " + std::to_string(kWidth) + " " +
                      std::to_string(kHeight + kText_px) +
                      "\" role=\"img\" aria-label=\"How much area has which values\">\n";
    for (std::size_t i = 0; i < bars.size(); ++i) {
        const double value = s.min + (static_cast<double>(i) + 0.5) * bar_width;
        // Where all values are alike, the one bar has no width of its own.
        const double left = std::max(0.0, find_x(value - bar_width / 2));
        const double right =
            std::min<double>(kWidth, std::max(find_x(value + bar_width / 2), left + 1));
        if (bars[i] == 0 || right <= left)
            continue;
        const double height = kHeight * static_cast<double>(bars[i]) / highest;
        out += "<rect x=\"" + number_text(left, 0.1) + "\" y=\"" +
               number_text(kHeight - height, 0.1) + "\" width=\"" +
               number_text(std::max(right - left, 1.0), 0.1) + "\" height=\"" +
               number_text(height, 0.1) + "\" fill=\"" + css(legend.to_colour(value)) +
               "\" stroke=\"currentColor\" stroke-opacity=\".35\" stroke-width=\".5\"/>\n";
    }
    for (const Tick& tick : legend.ticks) {
        const char* anchor = tick.share < 0.02 ? "start" : tick.share > 0.98 ? "end" : "middle";
        out += "<text x=\"" + number_text(tick.share * kWidth, 0.1) + "\" y=\"" +
               std::to_string(kHeight + kText_px - 4) +
               "\" font-size=\"14\" fill=\"currentColor\" text-anchor=\"" + anchor + "\">" +
               escaped_markup(tick.label) + "</text>\n";
    }
    return out + "</svg>\n";
}

std::string entries_table(const BandFacts& band, double cell_m) {
    std::string out = "<table>\n";
    const auto cells = static_cast<double>(band.statistics.cells);
    for (const LegendEntry& entry : band.legend->entries)
        out +=
            "<tr><td><svg viewBox=\"0 0 1 1\" style=\"width:1rem\"><rect width=\"1\" "
            "height=\"1\" fill=\"" +
            css(entry.colour) + "\"/></svg></td><td>" + escaped_markup(entry.name) +
            "</td><td class=\"n\">" + number_text(100 * entry.share, kPercentStep) +
            " %</td><td class=\"n\">" + area_text(entry.share * cells, cell_m) + "</td></tr>\n";
    return out + "</table>\n";
}

std::string figure(CellFile& cells, const BandFacts& band, const ReportFacts& facts) {
    const std::string title = escaped_markup(band.band.style.title);
    std::string out = "<h2>" + title + "</h2>\n<figure><img alt=\"Map: " + title +
                      "\" src=\"data:image/png;base64," +
                      base64(make_sheet(cells, band, facts, kMap_px)) + "\"></figure>\n";
    return out +
           (has_categories(band.legend->ramp) ? entries_table(band, facts.cell_m) : chart(band));
}

std::string bands_table(const std::vector<BandFacts>& bands, double cell_m) {
    std::string out =
        "<h2>All bands</h2>\n<table>\n<tr><th>Band</th><th>Unit</th><th class=\"n\">Area</th>"
        "<th class=\"n\">Least</th><th class=\"n\">5 %</th><th class=\"n\">Mean</th>"
        "<th class=\"n\">95 %</th><th class=\"n\">Most</th></tr>\n";
    for (const BandFacts& band : bands) {
        const BandStatistics& s = band.statistics;
        const bool is_category = has_categories(band.band.style.ramp);
        if (is_category || band.band.name == kHoleBand.name)
            continue;
        out += "<tr><td>" + escaped_markup(band.band.name) + "</td><td>" +
               escaped_markup(band.band.unit) + "</td><td class=\"n\">" +
               area_text(static_cast<double>(s.cells), cell_m) + "</td>";
        const double step = round_step(std::max(s.max - s.min, 1e-6), 500);
        // Directions have no mean, and no order.
        const bool is_around = band.band.style.ramp == Ramp::kAround;
        const auto value = [&](double v) {
            out += "<td class=\"n\">" + (s.cells == 0 || is_around ? "" : number_text(v, step)) +
                   "</td>";
        };
        value(s.min);
        value(s.quantile(0.05));
        value(s.mean);
        value(s.quantile(0.95));
        value(s.max);
        out += "</tr>\n";
    }
    return out + "</table>\n";
}

std::string facts_table(const CellFile& cells, const ReportFacts& facts) {
    std::string out = "<table>\n";
    const auto row = [&](const std::string& name, const std::string& value) {
        if (!value.empty())
            out += "<tr><td>" + escaped_markup(name) + "</td><td>" + escaped_markup(value) +
                   "</td></tr>\n";
    };
    row("Place", facts.place);
    row("Cells",
        std::to_string(cells.columns()) + " x " + std::to_string(cells.rows()) + " of " +
            number_text(facts.cell_m, std::floor(facts.cell_m) == facts.cell_m ? 1 : 0.001) + " m");
    row("Coordinate reference system", facts.crs);
    for (const auto& [name, value] : facts.settings)
        row(name, value);
    return out + "</table>\n";
}

std::string holes_warning(const BandFacts& hole, const ReportFacts& facts) {
    const double count = hole.statistics.mean * static_cast<double>(hole.statistics.cells);
    if (count < 0.5 && facts.missing_boxes == 0)
        return {};
    return "<p class=\"warning\">" + area_text(count, facts.cell_m) +
           " have no value, because data could not be read (" +
           std::to_string(facts.missing_boxes) +
           " boxes). They are magenta on the maps, and in no number here.</p>\n";
}

std::string page(CellFile& cells, const ReportFacts& facts, const std::stop_token& stop) {
    const std::string title =
        "Analysis: " + std::string(core::to_word(facts.kind)) + ", " + facts.place;
    std::string out =
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta "
        "name=\"viewport\" content=\"width=device-width\">\n<meta "
        "http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
        "style-src 'unsafe-inline'\">\n<title>" +
        escaped_markup(title) + "</title>\n<style>" + std::string(kStyle) + "</style>\n<h1>" +
        escaped_markup(title) + "</h1>\n";
    std::vector<BandFacts> bands;
    for (const RasterBand& band : cells.bands())
        bands.push_back(collect_facts(cells, band, stop));
    out += holes_warning(bands.back(), facts);
    out += facts_table(cells, facts);
    for (const BandFacts& band : bands)
        if (band.legend)
            out += figure(cells, band, facts);
    out += bands_table(bands, facts.cell_m);
    out += "<footer>";
    for (const std::string& text : {facts.attribution, facts.licence})
        if (!text.empty())
            out += "<p>" + escaped_markup(text) + "</p>";
    return out + "<p>Made with Terravox.</p></footer>\n</html>\n";
}

}  // namespace

void write_report(CellFile& cells, const std::filesystem::path& out, const ReportFacts& facts,
                  const std::stop_token& stop) {
    util::write_file_atomically(out, page(cells, facts, stop));
}

void write_map(CellFile& cells, const std::filesystem::path& out, const ReportFacts& facts,
               const std::stop_token& stop) {
    for (const RasterBand& band : cells.bands()) {
        const BandFacts drawn = collect_facts(cells, band, stop);
        if (!drawn.legend)
            continue;
        util::write_file_atomically(out, make_sheet(cells, drawn, facts, kPicture_px));
        return;
    }
    throw util::Error("draw the map " + out.string() +
                      ": no cell has a value; the area may lie outside of the data");
}

void check_report_target(const std::filesystem::path& out, const std::string& ending) {
    const std::string own = util::lower_extension(out);
    if (own != ending)
        throw util::UsageError("write the report " + out.string() + ": the ending '" + own +
                               "'; allowed: " + ending);
    util::check_writable(out);
}

}  // namespace terravox::analyse
