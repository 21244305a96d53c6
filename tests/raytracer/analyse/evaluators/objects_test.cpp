#include "raytracer/analyse/objects/objects.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "common/voxel/material.hpp"
#include "raytracer/analyse/objects/cell_labels.hpp"
#include "raytracer/analyse/objects/feature_file.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::TemporaryFolder;
using voxel::Material;

namespace {

using Grid = std::vector<std::vector<int>>;

analyse::EnergyCell cell(float kwh_m2, float slope_deg, float aspect_deg) {
    return {kwh_m2, 100, slope_deg, aspect_deg};
}

/// A raster of energies: a cell belongs to a building where the grid is above 0; 2: it has no value
/// there. Its energy is 1 and more from the north-west on.
std::unique_ptr<analyse::CellFile> to_raster(const TemporaryFolder& folder, const Grid& grid,
                                             int tile_px = 16) {
    const int columns = static_cast<int>(grid.front().size());
    const int rows = static_cast<int>(grid.size());
    auto out = std::make_unique<analyse::CellFile>(
        folder.path() / "a.tif", core::AnalysisKind::kEnergy, columns, rows, tile_px);
    const analyse::CellRectangle all{0, 0, columns, rows};
    const auto write = [&](const char* band, const auto& value_at) {
        std::vector<float> values;
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x)
                values.push_back(static_cast<float>(
                    value_at(grid[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)],
                             y * columns + x)));
        out->write(band, all, values);
    };
    const auto value = [](float number) {
        return [number](int kind, int) { return kind == 2 ? core::kNoData : number; };
    };
    write("kwh_m2", [](int kind, int i) { return kind == 2 ? core::kNoData : 1.0F + i * 0.1F; });
    write("sun_hours", value(1000));
    write("slope", value(60));
    write("aspect", value(180));
    write("material", [](int kind, int) {
        return static_cast<float>(kind > 0 ? Material::kGreyRoof : Material::kGrass);
    });
    return out;
}

/// Numbers of connected cells by filling one after the other; 0: none.
Grid filled(const Grid& grid) {
    Grid out(grid.size(), std::vector<int>(grid.front().size(), 0));
    int number = 0;
    const std::function<void(std::size_t, std::size_t)> fill = [&](std::size_t y, std::size_t x) {
        if (y >= grid.size() || x >= grid.front().size() || grid[y][x] == 0 || out[y][x] != 0)
            return;
        out[y][x] = number;
        fill(y + 1, x);
        fill(y - 1, x);
        fill(y, x + 1);
        fill(y, x - 1);
    };
    for (std::size_t y = 0; y < grid.size(); ++y)
        for (std::size_t x = 0; x < grid.front().size(); ++x)
            if (grid[y][x] != 0 && out[y][x] == 0) {
                ++number;
                fill(y, x);
            }
    return out;
}

Grid list_numbers(analyse::ConnectedCells& found) {
    Grid out;
    found.each_row([&](int, const std::vector<std::int32_t>& numbers) {
        out.emplace_back(numbers.begin(), numbers.end());
    });
    return out;
}

Grid random_grid(std::uint32_t seed) {
    std::mt19937 random(seed);
    Grid out(5 + random() % 40, std::vector<int>(3 + random() % 60));
    const std::uint32_t share = 20 + random() % 70;
    for (auto& row : out)
        for (int& value : row)
            value = random() % 100 < share ? 1 + static_cast<int>(random() % 8 == 0) : 0;
    return out;
}

output::GeoPlacement placement() {
    return {{462000, 2, 0, 101000, 0, -2}, geo::Crs::from_text("EPSG:3794").wkt()};
}

std::filesystem::path geojson(const TemporaryFolder& folder, const std::string& geometries,
                              const std::string& crs = "EPSG:3794") {
    const auto file = folder.path() / "polygons.geojson";
    std::ofstream(file) << R"({"type":"FeatureCollection","crs":{"type":"name","properties":)"
                        << R"({"name":")" << crs << R"("}},"features":[)" << geometries << "]}";
    return file;
}
std::string polygon(const std::string& rings, const char* type = "Polygon") {
    return R"({"type":"Feature","properties":{},"geometry":{"type":")" + std::string(type) +
           R"(","coordinates":)" + rings + "}}";
}

overlay::Footprint rectangle(double west, double north, double east, double south) {
    return overlay::Footprint({{{west, north}, {east, north}, {east, south}, {west, south}}});
}

/// Rectangles anywhere, also over each other and beyond the raster, some of two parts.
std::vector<analyse::ObjectPolygon> random_polygons(std::uint32_t seed, int columns, int rows) {
    std::mt19937 random(seed);
    const auto between = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    std::vector<analyse::ObjectPolygon> out(1 + random() % 40);
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i].feature = 2 * i;
        for (std::size_t part = 0; part <= i % 2; ++part) {
            const double west = between(-20, columns);
            const double north = between(-20, rows);
            const double side = random() % 5 == 0 ? 300 : 15;
            out[i].parts.push_back(
                rectangle(west, north, west + between(0.1, side), north + between(0.1, side)));
        }
    }
    return out;
}

/// The numbers of cells by their rule, each on its own.
Grid numbered(const std::vector<analyse::ObjectPolygon>& polygons, int columns, int rows,
              int near) {
    const auto inside = [&](int x, int y) {
        if (x < 0 || y < 0 || x >= columns || y >= rows)
            return 0;
        for (const analyse::ObjectPolygon& polygon : polygons)
            for (const overlay::Footprint& part : polygon.parts)
                if (part.contains(x + 0.5, y + 0.5))
                    return static_cast<int>(polygon.feature) + 1;
        return 0;
    };
    Grid own(static_cast<std::size_t>(rows));
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x)
            own[static_cast<std::size_t>(y)].push_back(inside(x, y));
    Grid out = own;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            int& number = out[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
            for (int far = 1; number == 0 && far <= near * near; ++far)
                for (int dy = -near; dy <= near; ++dy)
                    for (int dx = -near; dx <= near; ++dx) {
                        const int column = x + dx;
                        const int row = y + dy;
                        if (number == 0 && dx * dx + dy * dy == far && column >= 0 && row >= 0 &&
                            column < columns && row < rows)
                            number = own[static_cast<std::size_t>(row)]
                                        [static_cast<std::size_t>(column)];
                    }
        }
    return out;
}

Grid make_grid(const analyse::LabelFile& labels, int columns, int rows) {
    std::vector<std::int32_t> row(static_cast<std::size_t>(columns));
    Grid out;
    for (int y = 0; y < rows; ++y) {
        REQUIRE(GDALRasterIO(GDALGetRasterBand(labels.dataset(), 1), GF_Read, 0, y, columns, 1,
                             row.data(), columns, 1, GDT_Int32, 0, 0) == CE_None);
        out.emplace_back(row.begin(), row.end());
    }
    return out;
}

}  // namespace

TEST_CASE("cells have the number of the first polygon that holds their middle, or of a near one",
          "[raytracer][analyse]") {
    const TemporaryFolder folder;
    // Less than a block of the file, and several of them.
    struct Case {
        int columns;
        int rows;
    };
    const auto c = GENERATE(values<Case>({{1, 1}, {7, 90}, {530, 150}, {300, 64}}));
    for (std::uint32_t seed = 1; seed <= 4; ++seed) {
        INFO(c.columns << " x " << c.rows << " cells, seed " << seed);
        const auto polygons = random_polygons(seed, c.columns, c.rows);
        const int near = 1 + static_cast<int>(seed % 2);
        const analyse::LabelFile labels(folder.path() / "a.gpkg", polygons, c.columns, c.rows, near,
                                        {});
        CHECK(make_grid(labels, c.columns, c.rows) == numbered(polygons, c.columns, c.rows, near));
    }
}

TEST_CASE("a polygon of more cells than are in memory at a time is numbered to its end",
          "[raytracer][analyse]") {
    constexpr int kColumns = 3000;
    constexpr int kRows = 800;
    std::vector<analyse::ObjectPolygon> polygons(1);
    polygons[0].parts.emplace_back(overlay::Footprint({{{10, 5}, {2990, 400}, {20, 795}}}));
    const TemporaryFolder folder;
    const analyse::LabelFile labels(folder.path() / "a.gpkg", polygons, kColumns, kRows, 1, {});
    CHECK(make_grid(labels, kColumns, kRows) == numbered(polygons, kColumns, kRows, 1));
}

TEST_CASE("an object's area and energy are along its slopes", "[raytracer][analyse]") {
    analyse::ObjectSums sums;
    // 60 degrees: twice as much surface as on the map.
    sums.add(cell(1000, 60, 170), 4);
    sums.add(cell(1000, 60, 190), 4);
    sums.add(cell(500, 0, core::kNoData), 4);
    sums.add(cell(400, 60, 350), 4);
    sums.add(cell(core::kNoData, core::kNoData, core::kNoData), 4);
    const analyse::ObjectFacts facts = analyse::collect_facts(sums, 4);
    CHECK(facts.cells == 5);
    CHECK(facts.cells_without_value == 1);
    CHECK(facts.area_m2 == 20);
    CHECK(facts.surface_m2 == Approx(3 * 8 + 4));
    CHECK(facts.kwh == Approx(16 * 1000 + 4 * 500 + 8 * 400));
    CHECK(facts.kwh_m2() == Approx(facts.kwh / 28));
    CHECK(facts.sun_hours == Approx(100));
    CHECK(facts.best == analyse::Facing::kSouth);
    CHECK(facts.best_azimuth_deg == Approx(180));
    CHECK(facts.best_slope_deg == Approx(60).margin(0.5));
    CHECK(facts.best_surface_m2 == Approx(16));
    CHECK(facts.best_kwh == Approx(16000));
    analyse::ObjectSums none;
    none.add(cell(core::kNoData, 0, 0), 4);
    CHECK_FALSE(analyse::collect_facts(none, 4).has_values());
}

TEST_CASE("connected cells are those that a fill finds, and lose no energy",
          "[raytracer][analyse]") {
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        INFO("seed " << seed);
        const Grid grid = random_grid(seed);
        const TemporaryFolder folder;
        const auto cells = to_raster(folder, grid);
        analyse::ConnectedCells found(*cells, 4, {});
        const Grid expected = filled(grid);
        REQUIRE(list_numbers(found) == expected);
        std::map<int, double> kwh;
        std::map<int, std::uint64_t> without_value;
        const auto columns = grid.front().size();
        for (std::size_t y = 0; y < grid.size(); ++y)
            for (std::size_t x = 0; x < columns; ++x) {
                const auto i = static_cast<float>(y * columns + x);
                without_value[expected[y][x]] += grid[y][x] == 2 ? 1 : 0;
                kwh[expected[y][x]] +=
                    grid[y][x] == 1 ? 8 * static_cast<double>(1.0F + i * 0.1F) : 0;
            }
        for (std::size_t i = 0; i < found.facts().size(); ++i) {
            REQUIRE(found.facts()[i].kwh == Approx(kwh[static_cast<int>(i) + 1]));
            REQUIRE(found.facts()[i].cells_without_value == without_value[static_cast<int>(i) + 1]);
        }
        // Another size of blocks, the same bits.
        const TemporaryFolder other;
        const auto again = to_raster(other, grid, 48);
        const analyse::ConnectedCells same(*again, 4, {});
        REQUIRE(same.facts().size() == found.facts().size());
        for (std::size_t i = 0; i < found.facts().size(); ++i)
            REQUIRE(same.facts()[i].kwh == found.facts()[i].kwh);
    }
}

TEST_CASE("polygons count the cells whose middles they hold", "[raytracer][analyse]") {
    const TemporaryFolder folder;
    const auto cells = to_raster(folder, Grid(10, std::vector<int>(12, 1)));
    // In cells: 2 to 6 from the west, 1 to 4 from the north, without one cell; and two parts, of
    // which one reaches beyond the raster.
    const auto file = geojson(
        folder, polygon("[[[462004,100998],[462012,100998],[462012,100992],[462004,100992],"
                        "[462004,100998]],[[462006,100996],[462006,100994],[462008,100994],"
                        "[462008,100996],[462006,100996]]]") +
                    "," +
                    polygon("[[[[461998,101000],[462002,101000],[462002,100998],[461998,100998],"
                            "[461998,101000]]],[[[462020,100984],[462024,100984],[462024,100982],"
                            "[462020,100982],[462020,100984]]]]",
                            "MultiPolygon"));
    const auto polygons = analyse::read_polygons(file, placement(), 12, 10);
    REQUIRE(polygons.size() == 2);
    const auto facts = analyse::collect_facts(*cells, polygons, 4, {});
    CHECK(facts[0].cells == 4 * 3 - 1);
    CHECK(facts[0].area_m2 == 44);
    CHECK(facts[0].cells_without_value == 0);
    double kwh = 0;
    for (int y = 1; y < 4; ++y)
        for (int x = 2; x < 6; ++x)
            kwh += y == 2 && x == 3 ? 0 : 8 * (1 + (y * 12 + x) * 0.1);
    CHECK(facts[0].kwh == Approx(kwh));
    CHECK(facts[1].cells == 2 + 2);
    CHECK(facts[1].cells_without_value == 1);
}

TEST_CASE("what lies beyond the raster costs nothing, however far a polygon reaches",
          "[raytracer][analyse]") {
    const TemporaryFolder folder;
    const auto cells = to_raster(folder, Grid(10, std::vector<int>(12, 1)));
    struct Case {
        const char* name;
        std::vector<overlay::Footprint::Ring> rings;  // in cells
        std::uint64_t inside;
        std::uint64_t beyond;
    };
    // The last corner of a ring is joined with its first.
    const auto c = GENERATE(values<Case>({
        {"all of a raster and a million cells around it",
         {{{-1e6, -1e6}, {1e6, -1e6}, {1e6, 1e6}, {-1e6, 1e6}}},
         120,
         4'000'000'000'000 - 120},
        {"as far as is allowed to the east, a row high",
         {{{3, 2}, {1e9, 2}, {1e9, 3}, {3, 3}}},
         9,
         1'000'000'000 - 12},
        {"a triangle whose sides cross those of the raster",
         {{{-6, 5}, {12, -4}, {12, 14}}},
         6 + 8 + 8 + 9 * 10,
         18 * 18 / 2 - 112},
        {"a hole in the raster and beyond it",
         {{{0, 0}, {100, 0}, {100, 10}, {0, 10}}, {{6, 2}, {20, 2}, {20, 4}, {6, 4}}},
         120 - 12,
         880 - 16},
        {"beside the raster", {{{12, 0}, {20, 0}, {20, 5}, {12, 5}}}, 0, 40},
    }));
    DYNAMIC_SECTION(c.name) {
        std::vector<analyse::ObjectPolygon> polygons(1);
        polygons[0].parts.emplace_back(c.rings);
        const analyse::ObjectFacts facts = analyse::collect_facts(*cells, polygons, 4, {})[0];
        CHECK(facts.cells - facts.cells_without_value == c.inside);
        CHECK(facts.cells_without_value == c.beyond);
        CHECK(facts.area_m2 == 4 * static_cast<double>(c.inside + c.beyond));
    }
}

TEST_CASE("polygons of longitude and latitude are transformed", "[raytracer][analyse]") {
    const TemporaryFolder folder;
    const geo::Crs crs = geo::Crs::from_text("EPSG:3794");
    std::string ring;
    for (const auto& [x, y] : {std::pair{462004.0, 100998.0},
                               {462012.0, 100998.0},
                               {462012.0, 100992.0},
                               {462004.0, 100992.0},
                               {462004.0, 100998.0}}) {
        const geo::LatLon at = geo::to_lat_lon(crs, x, y);
        char text[80];
        std::snprintf(text, sizeof text, "%s[%.10f,%.10f]", ring.empty() ? "" : ",", at.lon_deg,
                      at.lat_deg);
        ring += text;
    }
    const auto file = geojson(folder, polygon("[[" + ring + "]]"), "OGC:CRS84");
    const auto polygons = analyse::read_polygons(file, placement(), 12, 10);
    CHECK(polygons[0].parts[0].min()[0] == Approx(2).margin(1e-3));
    CHECK(polygons[0].parts[0].max()[1] == Approx(4).margin(1e-3));
}

TEST_CASE("what is no valid polygon is refused", "[raytracer][analyse]") {
    const TemporaryFolder folder;
    struct Wrong {
        const char* name;
        std::string feature;
        const char* says;
    };
    const Wrong wrong[] = {
        {"a bow",
         polygon("[[[462000,100990],[462010,100980],[462010,100990],[462000,100980],"
                 "[462000,100990]]]"),
         "feature 0 is not valid"},
        {"open", polygon("[[[462000,100990],[462010,100980],[462010,100990],[462000,100980]]]"),
         "not closed"},
        {"a point", polygon("[462000,100990]", "Point"), "no polygon"},
        {"nothing", "", "holds none"},
        {"parts that overlap",
         polygon("[[[[462000,100990],[462010,100990],[462010,100980],[462000,100990]]],"
                 "[[[462000,100990],[462010,100990],[462010,100980],[462000,100990]]]]",
                 "MultiPolygon"),
         "not valid"},
        {"elsewhere", polygon("[[[1,1],[9,1],[9,9],[1,1]]]"), "none of them meets"},
        {"far away", polygon("[[[462000,100990],[1e300,100990],[1e300,100980],[462000,100990]]]"),
         "farther than 10^9 cells"},
    };
    for (const Wrong& one : wrong) {
        INFO(one.name);
        const auto file = geojson(folder, one.feature);
        CHECK_THROWS_WITH(analyse::read_polygons(file, placement(), 12, 10),
                          test::contains(one.says) && test::contains("polygons.geojson"));
    }
}

TEST_CASE("a file of objects appears when it is complete, and a stop leaves nothing",
          "[raytracer][analyse]") {
    const TemporaryFolder folder;
    const auto cells = to_raster(folder, random_grid(5));
    const auto out = folder.path() / "a.gpkg";
    std::stop_source stop;
    stop.request_stop();
    CHECK_THROWS_WITH(
        analyse::write_objects(*cells, out, {placement(), ""}, {}, 4, stop.get_token()),
        "interrupted");
    CHECK_FALSE(std::filesystem::exists(out));
    CHECK(analyse::write_objects(*cells, out, {placement(), ""}, {}, 4, {}) > 3);
    CHECK(std::filesystem::exists(out));
    CHECK_THROWS_AS(analyse::check_object_target("a.shp"), util::UsageError);
}
