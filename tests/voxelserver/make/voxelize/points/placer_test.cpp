// Where a return lands: the exact voxel, by hand-made files with one point each.
#include <cmath>
#include <random>

#include "tests/catch.hpp"
#include "voxelserver/make/voxelize/points/placer.hpp"

using namespace terravox;
using namespace terravox::voxelize;

namespace {

const ClassTable& asprs() {
    static const ClassTable table = load_class_table("asprs");
    return table;
}

/// A file of quarter metres around its CRS's origin: coordinates are exact.
SquareSource find_source(const std::string& crs, double scale = 0.25) {
    SquareSource out;
    out.info.scale = {scale, scale, scale};
    out.info.min = {-1e6, -1e6, -1e4};
    out.info.max = {1e6, 1e6, 1e4};
    out.info.crs = geo::Crs::from_text(crs);
    out.lowest = -1e4;
    out.highest = 1e4;
    return out;
}

/// The same with bounds that hold everything.
SquareSource without_bounds(SquareSource s) {
    s.info.min = {-1e300, -1e300, -1e300};
    s.info.max = {1e300, 1e300, 1e300};
    s.lowest = -1e12;
    s.highest = 1e12;
    return s;
}

pointcloud::Point raw(const SquareSource& s, double e, double n, double h, int source_class = 2) {
    pointcloud::Point p;
    const auto of = [&](double v, std::size_t axis) {
        return std::round((v - s.info.offset[axis]) / s.info.scale[axis]) * s.info.scale[axis] +
               s.info.offset[axis];
    };
    p.x = of(e, 0);
    p.y = of(n, 1);
    p.z = of(h, 2);
    p.classification = static_cast<std::uint8_t>(source_class);
    return p;
}

struct Placed {
    store::PatchedPoints out;
    store::PointCounts counts;
    [[nodiscard]] std::array<std::int32_t, 3> voxel(std::size_t i = 0) const {
        std::size_t r = 0;
        while (r + 1 < out.runs.size() && out.runs[r + 1].begin <= i)
            ++r;
        const store::VoxelPoint& p = out.points.at(i);
        return {out.runs[r].patch.x0() + (p.x >> store::VoxelPoint::kPlanBits), p.voxel_y(),
                out.runs[r].patch.z0() + (p.z >> store::VoxelPoint::kPlanBits)};
    }
};

Placed place(const SquareSource& source, const grid::Frame& frame,
             const std::vector<pointcloud::Point>& points, const Settings::Points& filters = {},
             const std::optional<grid::PatchRect>& wanted = {}) {
    Placed out;
    Placer(source, frame, asprs(), filters).place(points, wanted, out.out, out.counts);
    return out;
}

constexpr const char* kMetres = "EPSG:2154";

}  // namespace

TEST_CASE("a return lands in the voxel that its coordinates are floored to",
          "[voxelserver][voxelize][placer]") {
    struct Case {
        const char* name;
        double voxel_m;
        double e;
        double n;
        double h;
        std::array<std::int32_t, 3> voxel;
    };
    const auto c = GENERATE(values<Case>({
        {"on the voxel's western, southern and lower border", 1, 10, 10, 3, {10, 3, -10}},
        {"just below a border", 1, 9.75, 9.75, 2.75, {9, 2, -10}},
        {"west of the origin", 1, -0.25, 0.25, -0.25, {-1, -1, -1}},
        {"first column of a patch", 1, 64, -64, 0.5, {64, 0, 64}},
        {"last column of a negative patch", 1, -64.25, 64.25, 0, {-65, 0, -65}},
        {"two metres", 2, -10.25, 10.25, -3.75, {-6, -2, -6}},
    }));
    DYNAMIC_SECTION(c.name) {
        const SquareSource source = find_source(kMetres);
        const grid::Frame frame(geo::Crs::from_text(kMetres), c.voxel_m, 0, 0);
        const Placed placed = place(source, frame, {raw(source, c.e, c.n, c.h)});
        REQUIRE(placed.counts.kept == 1);
        CHECK(placed.voxel() == c.voxel);
    }
}

TEST_CASE("feet are feet: of the survey sideways, and whatever the file counts upwards",
          "[voxelserver][voxelize][placer]") {
    constexpr double kUsFoot = 1200.0 / 3937.0;
    struct Case {
        const char* name;
        const char* crs;
        double vertical_metres;
        double e;
        double h;
    };
    const auto c = GENERATE(values<Case>({
        {"US survey feet both ways", "EPSG:2263", kUsFoot, 999'983.25, 1234.75},
        {"US survey feet, heights in metres", "EPSG:2263", 1, 999'983.25, 1234.75},
        {"metres, heights in feet", kMetres, 0.3048, 999'983.25, -1234.75},
    }));
    DYNAMIC_SECTION(c.name) {
        SquareSource source = find_source(c.crs);
        source.vertical_metres = c.vertical_metres;
        const double unit_m = std::string(c.crs) == kMetres ? 1 : kUsFoot;
        const grid::Frame frame(geo::Crs::from_text(c.crs), 1, 0, 0);
        const Placed placed = place(source, frame, {raw(source, c.e, -c.e, c.h)});
        REQUIRE(placed.counts.kept == 1);
        const auto sideways = static_cast<std::int32_t>(std::floor(c.e * unit_m));
        CHECK(placed.voxel() ==
              std::array{sideways, static_cast<std::int32_t>(std::floor(c.h * c.vertical_metres)),
                         sideways});
    }
}

TEST_CASE("what is no return of the land is left out and counted",
          "[voxelserver][voxelize][placer]") {
    SquareSource source = find_source(kMetres);
    source.info.min = {1000, 2000, 100};
    source.info.max = {1500, 2500, 400};  // rounding of quarter metres is half a metre
    source.lowest = 90;
    source.highest = 410;
    const grid::Frame frame(geo::Crs::from_text(kMetres), 1, 0, 0);
    const auto with = [&](double e, double n, double h, int source_class = 2, bool withheld = false,
                          bool overlap = false) {
        auto p = raw(source, e, n, h, source_class);
        p.withheld = withheld;
        p.overlap = overlap;
        return p;
    };
    struct Case {
        const char* name;
        pointcloud::Point point;
        Settings::Points filters;
        const char* counted;
    };
    Settings::Points usual;
    Settings::Points all;
    Settings::Points no_overlap;
    all.drop_withheld = false;
    no_overlap.drop_overlap = true;
    const auto c = GENERATE_COPY(values<Case>({
        {"kept", with(1200, 2200, 200), usual, "kept"},
        {"within rounding", with(999.5, 2500.5, 90), usual, "kept"},
        {"west of it", with(999.25, 2200, 200), usual, "outlier"},
        {"north of it", with(1200, 2500.75, 200), usual, "outlier"},
        {"too low", with(1200, 2200, 89.75), usual, "outlier"},
        {"too high", with(1200, 2200, 410.25), usual, "outlier"},
        {"at the highest", with(1200, 2200, 410), usual, "kept"},
        {"too high, whatever the filters", with(1200, 2200, 4100), all, "outlier"},
        {"withheld", with(1200, 2200, 200, 2, true), usual, "withheld"},
        {"withheld, and wanted so", with(1200, 2200, 200, 2, true), all, "kept"},
        {"overlap", with(1200, 2200, 200, 2, false, true), usual, "kept"},
        {"overlap, not wanted", with(1200, 2200, 200, 2, false, true), no_overlap, "withheld"},
        {"low noise", with(1200, 2200, 200, 7), usual, "noise"},
        {"high noise, whatever the filters", with(1200, 2200, 200, 18), all, "noise"},
        {"a class that no table names", with(1200, 2200, 200, 201), usual, "kept"},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto placed = place(source, frame, {c.point}, c.filters);
        const store::PointCounts& n = placed.counts;
        CHECK(n.kept + n.outliers + n.withheld + n.noise == 1);
        CHECK(placed.out.points.size() == n.kept);
        CHECK((n.kept == 1       ? "kept"
               : n.outliers == 1 ? "outlier"
               : n.withheld == 1 ? "withheld"
                                 : "noise") == std::string(c.counted));
        CHECK(n.by_class[c.point.classification] == n.kept);
    }
}

TEST_CASE("bounds of a single place hold what lies there", "[voxelserver][voxelize][placer]") {
    SquareSource source = find_source(kMetres);
    source.info.min = {7, 8, 100};
    source.info.max = {7, 8, 100};
    source.lowest = source.highest = 100;
    const grid::Frame frame(geo::Crs::from_text(kMetres), 1, 0, 0);
    const Placed placed = place(
        source, frame, {raw(source, 7, 8, 100), raw(source, 8, 8, 100), raw(source, 7, 8, 100.25)});
    CHECK((placed.counts.kept == 1 && placed.counts.outliers == 2));
}

TEST_CASE("a return between parts of a file that lie far apart is an outlier",
          "[voxelserver][voxelize][placer]") {
    SquareSource source = find_source(kMetres);
    source.islands = {{0, 0, 100, 100}, {9000, 0, 9100, 100}};
    const grid::Frame frame(geo::Crs::from_text(kMetres), 1, 0, 0);
    const Placed placed =
        place(source, frame,
              {raw(source, 0, 0, 1), raw(source, 99.75, -99.75, 1), raw(source, 9000, -50, 1),
               raw(source, 100, -50, 1), raw(source, 5000, -50, 1), raw(source, 9000, 0.25, 1)});
    CHECK((placed.counts.kept == 3 && placed.counts.outliers == 3));
}

TEST_CASE("coordinates beyond 32-bit voxels are outliers, whatever the bounds",
          "[voxelserver][voxelize][placer]") {
    const SquareSource source = without_bounds(
        find_source(kMetres, 1000));  // kilometres: raw coordinates of 32 bits reach 2e12 m
    const grid::Frame frame(geo::Crs::from_text(kMetres), 1, 0, 0);
    struct Case {
        const char* name;
        std::int32_t x;
        std::int32_t y;
        std::int32_t z;
        bool kept;
    };
    const auto c = GENERATE(values<Case>({
        {"just inside", 999'999, -999'999, 524, true},
        {"east", 1'000'000, 0, 0, false},
        {"farthest west", INT32_MIN, 0, 0, false},
        {"north", 0, 1'000'000, 0, false},
        {"farthest south", 0, INT32_MIN, 0, false},
        {"up", 0, 0, 525, false},
        {"down", 0, 0, -525, false},
    }));
    DYNAMIC_SECTION(c.name) {
        pointcloud::Point p;
        p.x = c.x * 1000.0;
        p.y = c.y * 1000.0;
        p.z = c.z * 1000.0;
        p.classification = 2;
        const Placed placed = place(source, frame, {p});
        CHECK(placed.counts.kept == (c.kept ? 1 : 0));
        CHECK(placed.counts.outliers == (c.kept ? 0 : 1));
        if (c.kept)
            CHECK(placed.voxel() == std::array{c.x * 1000, c.z * 1000, -c.y * 1000});
    }
}

TEST_CASE("only points of wanted patches are kept, and others are not counted",
          "[voxelserver][voxelize][placer]") {
    const SquareSource source = find_source(kMetres);
    const grid::Frame frame(geo::Crs::from_text(kMetres), 1, 0, 0);
    std::vector<pointcloud::Point> points;
    for (const double e : {-0.25, 0.0, 63.75, 64.0})
        for (const double z : {-0.25, 0.0, 63.75, 64.0})
            points.push_back(raw(source, e, -z, 1));
    const Placed placed = place(source, frame, points, {}, grid::PatchRect{{0, 0}, {1, 1}});
    REQUIRE(placed.counts.kept == 4);
    CHECK(placed.counts.by_class[2] == 4);
    for (std::size_t i = 0; i < 4; ++i)
        CHECK((placed.voxel(i)[0] == 0 || placed.voxel(i)[0] == 63));
}

TEST_CASE("colours of 8 and of 16 bits become bytes", "[voxelserver][voxelize][placer]") {
    struct Case {
        const char* name;
        bool has;
        int shift;
        std::array<std::uint16_t, 3> rgb;
        voxel::Rgb8 wanted;
    };
    const auto c = GENERATE(values<Case>({
        {"16 bits", true, 8, {0xFFFF, 0x8000, 0x00FF}, {255, 128, 0}},
        {"8 bits", true, 0, {255, 128, 7}, {255, 128, 7}},
        {"a bright one where the sample had none", true, 0, {256, 65535, 0}, {255, 255, 0}},
        {"none", false, 0, {255, 255, 255}, {0, 0, 0}},
    }));
    DYNAMIC_SECTION(c.name) {
        SquareSource source = find_source(kMetres);
        source.has_colour = c.has;
        source.colour_shift = c.shift;
        auto p = raw(source, 1, 1, 1);
        p.rgb = c.rgb;
        CHECK(place(source, grid::Frame(geo::Crs::from_text(kMetres), 1, 0, 0), {p})
                  .out.points.at(0)
                  .colour == c.wanted);
    }
}

TEST_CASE(
    "returns of another system lie where its transformation puts them, in one batch or in many",
    "[voxelserver][voxelize][placer]") {
    SquareSource source = find_source("EPSG:32631", 0.01);
    source.info.offset = {570'000, 4'830'000, 0};
    source.info.min = {560'000, 4'820'000, 0};
    source.info.max = {580'000, 4'840'000, 100};
    source.transform = true;
    const auto lambert = geo::Crs::from_text(kMetres);
    const grid::Frame frame(lambert, 1, 0, 0);
    std::mt19937 random(3);
    std::vector<pointcloud::Point> points;
    std::vector<double> x;
    std::vector<double> y;
    for (int i = 0; i < 500; ++i) {
        points.push_back(raw(source, 570'000 + static_cast<double>(random() % 100'000) / 100,
                             4'830'000 + static_cast<double>(random() % 100'000) / 100, 5));
        x.push_back(points.back().x);
        y.push_back(points.back().y);
    }
    geo::Transform(*source.info.crs, lambert).apply(x, y);
    const Placed whole = place(source, frame, points);
    REQUIRE(whole.counts.kept == points.size());
    Placer placer(source, frame, asprs(), {});
    Placed pieces;
    for (std::size_t i = 0; i < points.size(); i += 7)
        placer.place(std::span(points).subspan(i, std::min<std::size_t>(7, points.size() - i)), {},
                     pieces.out, pieces.counts);
    for (std::size_t i = 0; i < points.size(); ++i) {
        INFO("point " << i);
        CHECK(whole.voxel(i) == std::array{static_cast<std::int32_t>(std::floor(x[i])), 5,
                                           static_cast<std::int32_t>(std::floor(-y[i]))});
        CHECK(pieces.voxel(i) == whole.voxel(i));
    }
}
