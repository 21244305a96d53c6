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
svg { width: 100%; height: auto; }
table { border-collapse: collapse; }
th, td { padding: .2rem .8rem .2rem 0; text-align: left; vertical-align: top; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
tr { border-bottom: 1px solid #8884; }
.warning { border-left: .3rem solid #c33; padding-left: .8rem; }
footer { margin-top: 3rem; font-size: .9rem; }
@media print { body { margin: 0; max-width: none; } h2, svg { break-inside: avoid; } }
)";

BandFacts collect_facts(CellFile& cells, const RasterBand& band, const std::stop_token& stop) {
    BandFacts out{band, measure_statistics(cells, band.name, stop), {}};
    if (band.style.title.empty() || !band.style.is_reported || out.statistics.cells == 0)
        return out;
    out.legend = has_categories(band.style.ramp)
                     ? categories_for(band.style, count_values(cells, band.name, stop))
                     : scale_for(band.style, out.statistics);
    return out;
}

std::string make_sheet(CellFile& cells, const BandFacts& band, const ReportFacts& facts,
                       bool is_file) {
    const MapPicture picture =
        draw_band(cells, band.band.name, *band.legend, is_file ? kPicture_px : kMap_px);
    return map_sheet(picture, band, facts.cell_m, facts.attribution, is_file);
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
            out += "<h2>" + escaped_markup(band.band.style.title) + "</h2>\n" +
                   make_sheet(cells, band, facts, false);
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
        util::write_file_atomically(out, make_sheet(cells, drawn, facts, true));
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
