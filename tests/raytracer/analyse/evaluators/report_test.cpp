#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>

#include "common/util/error.hpp"
#include "raytracer/analyse/report/html_report.hpp"
#include "raytracer/analyse/report/map_sheet.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::TemporaryFolder;

namespace {

constexpr int kColumns = 150;
constexpr int kRows = 100;

/// A raster of an analysis of the sky, whose first band is given by column and row.
template <class Value>
std::unique_ptr<analyse::CellFile> sky_raster(const TemporaryFolder& folder, const Value& value_at,
                                              int columns = kColumns, int rows = kRows) {
    auto cells = std::make_unique<analyse::CellFile>(folder.path() / "sky.tif",
                                                     core::AnalysisKind::kSky, columns, rows, 64);
    std::vector<float> first;
    std::vector<float> hole;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            first.push_back(static_cast<float>(value_at(x, y)));
            hole.push_back(first.back() == core::kNoData && y % 2 == 1 ? 1.0F : 0.0F);
        }
    const analyse::CellRectangle all{0, 0, columns, rows};
    cells->write("svf", all, first);
    cells->write("sky_view_solid", all, first);
    cells->write("openness", all, first);
    cells->write("hole", all, hole);
    return cells;
}

std::string read(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::size_t count_matches(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++count;
    return count;
}

const analyse::BandStyle& style_for(core::AnalysisKind kind, std::string_view band) {
    const auto& bands = analyse::find_analysis(kind).bands;
    return std::find_if(bands.begin(), bands.end(),
                        [&](const auto& one) { return one.name == band; })
        ->style;
}

analyse::ReportFacts some_facts() {
    analyse::ReportFacts facts;
    facts.kind = core::AnalysisKind::kSky;
    facts.place = "A & <B>";
    facts.attribution = "People \"of\" a survey";
    facts.cell_m = 2;
    return facts;
}

}  // namespace

TEST_CASE("statistics of a band are those of its values", "[raytracer][analyse]") {
    const TemporaryFolder folder;
    const auto value_at = [](int x, int y) {
        return x == 3 ? core::kNoData : static_cast<float>(x + 1000 * (y / 50));
    };
    const auto cells = sky_raster(folder, value_at);
    const auto found = analyse::measure_statistics(*cells, "svf", {});
    CHECK(found.cells == (kColumns - 1) * kRows);
    CHECK(found.min == 0);
    CHECK(found.max == kColumns - 1 + 1000);
    double sum = 0;
    for (int x = 0; x < kColumns; ++x)
        sum += x == 3 ? 0 : x + 500;
    CHECK(found.mean == Approx(sum / (kColumns - 1)));
    std::uint64_t binned = 0;
    for (const std::uint64_t bin : found.bins)
        binned += bin;
    CHECK(binned == found.cells);
    const double bin_width = (found.max - found.min) / analyse::BandStatistics::kBins;
    CHECK(std::abs(found.quantile(0.25) - 75) <= bin_width + 1);
    CHECK(found.quantile(1) == Approx(found.max));

    const auto counts = analyse::count_values(*cells, "svf", {});
    CHECK(counts.size() == 2 * (kColumns - 1));
    CHECK(counts.at(1007) == kRows / 2);
    CHECK(counts.count(3) == 0);
}

TEST_CASE("a band without values has statistics of nothing", "[raytracer][analyse]") {
    const TemporaryFolder folder;
    const auto cells = sky_raster(folder, [](int, int) { return core::kNoData; });
    CHECK(analyse::measure_statistics(*cells, "svf", {}).cells == 0);
    // A report of it is still one, with a table and no map.
    const auto out = folder.path() / "report.html";
    analyse::write_report(*cells, out, some_facts(), {});
    CHECK(count_matches(read(out), "<image") == 0);
    CHECK_THROWS_AS(analyse::write_map(*cells, folder.path() / "map.svg", some_facts(), {}),
                    util::Error);
    CHECK_FALSE(std::filesystem::exists(folder.path() / "map.svg"));
}

TEST_CASE("scales have round ends, and ticks within them", "[raytracer][analyse]") {
    struct Step {
        double length;
        int count;
        double step;
    };
    for (const auto& [length, count, step] :
         {Step{1, 5, 0.2}, Step{100, 5, 20}, Step{37, 5, 10}, Step{0.003, 5, 0.001}, Step{12, 5, 5},
          Step{1e7, 2, 5e6}})
        CHECK(analyse::round_step(length, count) == Approx(step));
    CHECK(analyse::number_text(1.25, 0.5) == "1.2");
    CHECK(analyse::number_text(-0.0001, 0.5) == "0.0");
    CHECK(analyse::number_text(12345, 100) == "12345");

    analyse::BandStatistics s;
    s.cells = 256;
    s.min = 293.4;
    s.max = 411.8;
    s.bins.fill(1);
    const auto heights = analyse::scale_for(style_for(core::AnalysisKind::kTerrain, "dtm"), s);
    CHECK(heights.low <= 294.7);
    CHECK(heights.high >= 410.6);
    CHECK(heights.high - heights.low <= 2 * (s.max - s.min));
    REQUIRE(heights.ticks.size() >= 3);
    for (const analyse::Tick& tick : heights.ticks)
        CHECK((tick.share >= -1e-9 && tick.share <= 1 + 1e-9));
    // All values alike.
    s.min = s.max = 5;
    const auto flat = analyse::scale_for(style_for(core::AnalysisKind::kTerrain, "dtm"), s);
    CHECK(flat.high > flat.low);
    CHECK(flat.ticks.size() < 20);
    const auto fixed = analyse::scale_for(style_for(core::AnalysisKind::kSky, "svf"), s);
    CHECK((fixed.low == 0 && fixed.high == 1));
}

TEST_CASE("a map shows values, what has none, and what could not be read", "[raytracer][analyse]") {
    const TemporaryFolder folder;
    // The right half has no value; its odd rows are holes.
    const auto value_at = [](int x, int) { return x < 2 ? 0.25F : core::kNoData; };
    const auto cells = sky_raster(folder, value_at, 4, 4);
    const auto legend = analyse::scale_for(style_for(core::AnalysisKind::kSky, "svf"),
                                           analyse::measure_statistics(*cells, "svf", {}));
    const auto map = analyse::draw_band(*cells, "svf", legend, 20);
    REQUIRE((map.width == 20 && map.height == 20));
    CHECK(map.cells_per_px == Approx(0.2));
    const auto at = [&](int x, int y) {
        return map.pixels[static_cast<std::size_t>(y) * 20 + static_cast<std::size_t>(x)];
    };
    const map::Rgba8 low = analyse::colour_at(analyse::Ramp::kMuch, 0.25);
    CHECK(at(0, 0) == low);
    CHECK(at(9, 19) == low);
    CHECK(at(10, 0) == map::Rgba8{218, 218, 218, 255});
    CHECK(at(10, 5) == map::Rgba8{255, 0, 204, 255});
}

TEST_CASE("a report is one page without scripts, and its texts are escaped",
          "[raytracer][analyse]") {
    const TemporaryFolder folder;
    const auto cells =
        sky_raster(folder, [](int x, int y) { return x == y ? core::kNoData : (x + y) / 250.0F; });
    const auto out = folder.path() / "report.html";
    analyse::ReportFacts facts = some_facts();
    facts.settings = {{"directions", "<64>"}};
    analyse::write_report(*cells, out, facts, {});
    const std::string page = read(out);
    CHECK(count_matches(page, "<image") == 3);
    CHECK(count_matches(page, "data:image/png;base64,iVBOR") == 3);
    CHECK(count_matches(page, "<script") == 0);
    CHECK(count_matches(page, "http://") + count_matches(page, "https://") == 0);
    CHECK(count_matches(page, "A &amp; &lt;B&gt;") == 3);
    CHECK(count_matches(page, "&lt;64&gt;") == 1);
    CHECK(count_matches(page, "<td>sky_view_solid</td>") == 1);
    CHECK(count_matches(page, "class=\"warning\"") == 1);

    analyse::write_map(*cells, folder.path() / "map.svg", facts, {});
    const std::string map = read(folder.path() / "map.svg");
    CHECK(map.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\""));
    CHECK(count_matches(map, "data:image/png;base64,iVBOR") == 1);
    CHECK(count_matches(map, ">Sky-view factor</text>") == 1);
    CHECK(count_matches(map, ">People &quot;of&quot; a survey</text>") == 1);
    // 150 cells of 2 m: 50 m is the round length that fits about six times.
    CHECK(count_matches(map, ">50 m</text>") == 1);
    CHECK(count_matches(map, ">N</text>") == 1);
    for (const char* tick : {"0.0", "0.2", "0.4", "0.6", "0.8", "1.0"})
        CHECK(count_matches(map, ">" + std::string(tick) + "</text>") == 1);
}

TEST_CASE("a sheet of categories has the area of each, and a credit in any language",
          "[raytracer][analyse]") {
    const analyse::BandStyle& style = style_for(core::AnalysisKind::kTerrain, "class");
    analyse::BandFacts band;
    band.band.style = style;
    band.statistics.cells = 400;
    band.legend = analyse::categories_for(style, {{6, 100}, {2, 299}, {77, 1}});
    const analyse::MapPicture picture{2, 1, 1, {{1, 2, 3, 255}, {4, 5, 6, 255}}};
    const std::string credit = "\xe5\x9c\x8b\xe5\x9c\x9f <\xd8\xa7> \x01 " + std::string(300, 'x');
    const std::string sheet = analyse::map_sheet(picture, band, 10, credit, false);
    CHECK(count_matches(sheet, "xmlns") == 0);
    CHECK(count_matches(sheet, "ramp") == 0);
    // The most frequent one first.
    const auto ground = sheet.find(">ground</text>");
    const auto building = sheet.find(">building</text>");
    CHECK(ground < building);
    CHECK(building < sheet.find(">class 77</text>"));
    CHECK(count_matches(sheet, ">74.8 %, 2.99 ha</text>") == 1);
    CHECK(count_matches(sheet, ">25.0 %, 1.00 ha</text>") == 1);
    CHECK(count_matches(sheet, ">0.2 %, 100.0 m\xc2\xb2</text>") == 1);
    CHECK(count_matches(sheet, ">\xe5\x9c\x8b\xe5\x9c\x9f &lt;\xd8\xa7&gt; \\x01</text>") == 1);
    CHECK(count_matches(sheet, "x</text>") == 3);
}

TEST_CASE("a measure that is the same everywhere has a chart and a scale", "[raytracer][analyse]") {
    const TemporaryFolder folder;
    const auto cells = sky_raster(folder, [](int, int) { return 0.5F; });
    analyse::write_map(*cells, folder.path() / "map.svg", some_facts(), {});
    const std::string map = read(folder.path() / "map.svg");
    CHECK(count_matches(map, "M450.0 100V0.0H451.0V100z") == 1);
    CHECK(count_matches(map, "nan") + count_matches(map, "inf") == 0);
}
