#include "voxelserver/data/ply/ply_source.hpp"

#include <algorithm>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/ply/ply_bytes.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"

using namespace terravox;
using namespace terravox::ply;
using namespace terravox::test;
using pointcloud::Point;
using pointcloud::PointRange;

namespace {

std::vector<Point> made_points(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<Point> out(count);
    for (Point& p : out) {
        p.x = 770'000 + random() % 100'000 / 1000.0;
        p.y = 6'277'000 + random() % 100'000 / 1000.0;
        p.z = random() % 100'000 / 1000.0;
        p.classification = static_cast<std::uint8_t>(random());
        p.return_number = static_cast<std::uint8_t>(1 + random() % 15);
        p.return_count = 15;
        for (std::uint16_t& channel : p.rgb)
            channel = static_cast<std::uint16_t>(random());
    }
    return out;
}

bool same(const Point& a, const Point& b) {
    return a.x == b.x && a.y == b.y && a.z == b.z && a.classification == b.classification &&
           a.return_number == b.return_number && a.return_count == b.return_count &&
           a.rgb == b.rgb && a.withheld == b.withheld && a.overlap == b.overlap;
}

std::vector<Point> read(const PlySource& source, const std::vector<PointRange>& ranges) {
    std::vector<Point> out;
    source.read(ranges, [&](std::span<const Point> batch) {
        out.insert(out.end(), batch.begin(), batch.end());
    });
    return out;
}

std::vector<Point> read_all(const PlySource& source) {
    return read(source, {{0, source.info().point_count}});
}

/// A text file of two points. @param properties lines behind x, y and z @param rows of both points
std::string text_file(const std::string& properties, const std::string& rows,
                      const std::string& type = "double") {
    return "ply\nformat ascii 1.0\nelement vertex 2\nproperty " + type + " x\nproperty " + type +
           " y\nproperty " + type + " z\n" + properties + "end_header\n" + rows;
}

}  // namespace

TEST_CASE("text, little-endian and big-endian files give the points that were written",
          "[voxelserver][ply]") {
    const PlyKind kind = GENERATE(PlyKind::kText, PlyKind::kLittle, PlyKind::kBig);
    const TemporaryFolder folder;
    // More than two parts, and more than fit a buffer.
    const auto points = made_points(120'001, 7);
    write_content(folder.path() / "a.ply", ply_bytes(points, kind));
    const PlySource source(folder.path() / "a.ply");
    REQUIRE(source.info().point_count == points.size());
    const auto found = read_all(source);
    REQUIRE(found.size() == points.size());
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        wrong += same(found[i], points[i]) ? 0 : 1;
    CHECK(wrong == 0);

    const auto [low, high] = std::minmax_element(
        points.begin(), points.end(), [](const Point& a, const Point& b) { return a.y < b.y; });
    CHECK(source.info().min[1] == low->y);
    CHECK(source.info().max[1] == high->y);
    CHECK(source.info().measured_bounds);

    const std::vector<PointRange> ranges{{119'990, 120'001}, {5, 5}, {3, 7}, {49'999, 50'002}};
    std::vector<Point> wanted;
    for (const PointRange& range : ranges)
        wanted.insert(wanted.end(), points.begin() + static_cast<std::ptrdiff_t>(range.begin),
                      points.begin() + static_cast<std::ptrdiff_t>(range.end));
    const auto some = read(source, ranges);
    REQUIRE(some.size() == wanted.size());
    CHECK(std::equal(some.begin(), some.end(), wanted.begin(), same));
    CHECK_THROWS_WITH(read(source, {{0, 120'002}}), contains("it has 120001"));

    CHECK(source.parts(50'000) ==
          std::vector<PointRange>{{0, 50'000}, {50'000, 100'000}, {100'000, 120'001}});
    CHECK(source.parts(1).size() == 3);
    CHECK(source.parts(1'000'000) == std::vector<PointRange>{{0, 120'001}});
    const auto sample = source.sample(4096);
    CHECK(sample.size() == 4096);
    CHECK(same(sample.front(), points.front()));
    CHECK(sample.back().x != sample.front().x);
    CHECK_FALSE(source.sampled_all_over());
}

TEST_CASE("names of properties as programs write them are understood", "[voxelserver][ply]") {
    struct Case {
        const char* name;
        std::string properties;
        std::string rows = "1 2 3\n4 5 6\n";
        int source_class = 1;
        std::array<std::uint16_t, 3> rgb = {};
        const char* type = "double";
    };
    const std::string colours = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    const std::string diffuse =
        "property uchar diffuse_red\nproperty uchar diffuse_green\nproperty uchar diffuse_blue\n";
    const std::string class_between =
        "property float nx\nproperty uchar class\nproperty double gps_time\n";
    const auto c = GENERATE_COPY(values<Case>({
        {"nothing but places", ""},
        {"colours of 8 bits", colours, "1 2 3 10 20 255\n4 5 6 0 0 0\n", 1, {10, 20, 255}},
        {"diffuse colours", diffuse, "1 2 3 1 2 4\n4 5 6 0 0 0\n", 1, {1, 2, 4}},
        {"red alone is no colour", "property uchar red\n", "1 2 3 9\n4 5 6 9\n"},
        {"a class", "property uchar classification\n", "1 2 3 6\n4 5 6 2\n", 6},
        {"CloudCompare's", "property float scalar_Classification\n", "1 2 3 6.000000\n4 5 6 2\n",
         6},
        {"a label", "property int label\n", "1 2 3 5\n4 5 6 2\n", 5},
        {"others in their order", class_between, "1 2 3 0.5 17 1e9\n4 5 6 0.5 2 1e9\n", 17},
        {"lines that end like those of DOS", "", "1 2 3 \r\n4 5 6\r\n"},
        {"no end of the last line", "", "1 2 3\n4 5 6"},
        {"signs, tabs and exponents", "", "+1\t2e0   3\n4 5 6\n"},
        {"whole numbers", "", "1 2 3\n4 5 6\n", 1, {}, "int"},
        {"no faces", "element face 0\nproperty list uchar int vertex_indices\n"},
        {"another element", "element camera 1\nproperty float focus\n", "1 2 3\n4 5 6\n0.5\n"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        write_content(folder.path() / "a.ply", text_file(c.properties, c.rows, c.type));
        const auto points = read_all(PlySource(folder.path() / "a.ply"));
        REQUIRE(points.size() == 2);
        CHECK(points[0].x == 1);
        CHECK(points[0].y == 2);
        CHECK(points[0].z == 3);
        CHECK(points[1].z == 6);
        CHECK(points[0].classification == c.source_class);
        CHECK(points[0].rgb == c.rgb);
    }
}

TEST_CASE("damaged files, and files that are no point clouds, are refused with the reason",
          "[voxelserver][ply]") {
    const std::string two = "1 2 3\n4 5 6\n";
    const std::string header = "ply\nformat ascii 1.0\nelement vertex 2\n";
    const std::string binary =
        "ply\nformat binary_little_endian 1.0\nelement vertex 1000\nproperty float x\n"
        "property float y\nproperty float z\nend_header\n";
    std::string many;
    for (int i = 0; i < 300; ++i)
        many += "property double p" + std::to_string(i) + "\n";
    struct Case {
        const char* name;
        std::string bytes;
        const char* said;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"more properties than any program writes", text_file(many, ""),
         "more than 256 properties"},
        {"an empty file", "", "no 'end_header'"},
        {"another file", "solid cube\n", "its first line is not 'ply'"},
        {"a header cut short", header, "no 'end_header'"},
        {"a header without end", "ply\ncomment " + std::string(100'000, 'a'), "more than 64 KiB"},
        {"another version", "ply\nformat ascii 2.0\nend_header\n", "format ascii 2.0"},
        {"another encoding", "ply\nformat base64 1.0\nend_header\n", "allowed: ascii"},
        {"no format", "ply\nelement vertex 0\nproperty float x\nend_header\n", "no line 'format'"},
        {"no element", "ply\nformat ascii 1.0\nend_header\n", "missing; allowed: vertex"},
        {"faces first", "ply\nformat ascii 1.0\nelement face 1\nend_header\n", "'face'"},
        {"an unknown line", "ply\nformat ascii 1.0\nsurprise\nend_header\n", "'surprise'"},
        {"a count that is none", "ply\nformat ascii 1.0\nelement vertex -1\nend_header\n",
         "whole number"},
        {"a count beyond 64 bits",
         "ply\nformat ascii 1.0\nelement vertex 99999999999999999999\nend_header\n",
         "whole number"},
        {"a property of nothing", "ply\nformat ascii 1.0\nproperty float x\nend_header\n",
         "belongs to no element"},
        {"a list", header + "property list uchar int x\nend_header\n", "no list"},
        {"an unknown type", header + "property quad x\nend_header\n", "unknown type"},
        {"no height", header + "property float x\nproperty float y\nend_header\n" + two,
         "no property z"},
        {"a mesh",
         text_file("element face 1\nproperty list uchar int vertex_indices\n", two + "3 0 1 1\n"),
         "a mesh of 1 faces"},
        {"colours of floats",
         text_file("property float red\nproperty float green\nproperty float blue\n", two),
         "allowed: uchar or ushort"},
        {"more points than bytes", binary + std::string(100, '\0'), "at most 8 are there"},
        {"billions of points in a few bytes",
         "ply\nformat ascii 1.0\nelement vertex 9000000000000000000\nproperty float x\n"
         "property float y\nproperty float z\nend_header\n1 2 3\n",
         "at most 1 are there"},
        {"a line less", text_file("", "1000000 2000000 3000000\n"), "cut short"},
        {"a number less", text_file("", "1 2 3\n4 5.25\n"), "fewer than 3"},
        {"a number more", text_file("", "1 2 3 4\n4 5 6\n"), "more than 3"},
        {"an empty line", text_file("", "1 2 3\n\n4 5 6\n"), "point 1 has fewer"},
        {"a word", text_file("", "1 two 3\n4 5 6\n"), "'two'"},
        {"not a number", text_file("", "1 2 3\n4 5 nan\n"), "point 1: z = nan"},
        {"infinity", text_file("", "1 inf 3\n4 5 6\n"), "point 0: y = inf"},
        {"too large a number", text_file("", "1 1e999 3\n4 5 6\n"), "'1e999'"},
        {"a class above 255", text_file("property int label\n", "1 2 3 256\n4 5 6 0\n"),
         "label = 256"},
        {"a class between classes", text_file("property float class\n", "1 2 3 2.5\n4 5 6 0\n"),
         "from 0 to 255"},
        {"a colour above its type",
         text_file("property uchar red\nproperty uchar green\nproperty uchar blue\n",
                   "1 2 3 256 0 0\n4 5 6 0 0 0\n"),
         "red = 256"},
        {"a line without end", text_file("", "1 2 " + std::string(70'000, ' ') + "3\n4 5 6\n"),
         "longer than"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto file = folder.path() / "a.ply";
        write_content(file, c.bytes);
        CHECK_THROWS_AS(PlySource(file), util::Error);
        CHECK_THROWS_WITH(PlySource(file),
                          contains(c.said) && contains(file.string()) && !contains("\n"));
    }
}

TEST_CASE("a file that becomes shorter while it is open gives an error", "[voxelserver][ply]") {
    const PlyKind kind = GENERATE(PlyKind::kText, PlyKind::kBig);
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.ply";
    const std::string bytes = ply_bytes(made_points(5000, 1), kind);
    write_content(file, bytes);
    const PlySource source(file);
    write_content(file, bytes.substr(0, bytes.size() / 2));
    CHECK_THROWS_AS(read_all(source), util::Error);
}

TEST_CASE("the CRS is that of a comment, else of the .prj file", "[voxelserver][ply]") {
    struct Case {
        const char* name;
        std::string comment, beside, crs;  ///< "" = none
    };
    const std::string wkt = geo::Crs::from_text("EPSG:3794").wkt();
    const auto c = GENERATE_COPY(values<Case>({
        {"none", "", "", ""},
        {"a comment", "crs EPSG:2154", "", "EPSG:2154"},
        {"a comment with a colon", "CRS: EPSG:2154", "", "EPSG:2154"},
        {"a comment with heights", "crs EPSG:2154+5720", "", "EPSG:2154"},
        {"a comment of WKT", "crs " + wkt, "", "EPSG:3794"},
        {"a file next to it", "", wkt, "EPSG:3794"},
        {"both", "crs EPSG:2154", wkt, "EPSG:2154"},
        {"a comment of something else", "crsomething EPSG:2154", "", ""},
        {"a comment that is not understood", "crs somewhere", "", ""},
        {"a PROJ string, which is for persons", "crs +proj=utm +zone=31", "", ""},
        {"a file that is no WKT", "", "somewhere", ""},
        {"a file too large", "", wkt + std::string(70'000, ' '), ""},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        write_content(folder.path() / "a.ply",
                      ply_bytes(made_points(3, 1), PlyKind::kBig, c.comment));
        if (!c.beside.empty())
            write_content(folder.path() / "a.prj", c.beside);
        const PlySource source(folder.path() / "a.ply");
        REQUIRE(source.info().crs.has_value() == !c.crs.empty());
        if (!c.crs.empty())
            CHECK(source.info().crs->same_horizontal(geo::Crs::from_text(c.crs)));
    }
}

TEST_CASE("floats too coarse for their coordinates are warned of once", "[voxelserver][ply]") {
    struct Case {
        const char* name;
        const char* type;
        std::string rows;
        bool warned;
    };
    const auto c = GENERATE(values<Case>({
        {"floats near zero", "float", "1 2 3\n4 5 6\n", false},
        {"floats of a national grid", "float", "770000 6277000 3\n770001 6277000 3\n", true},
        {"doubles of a national grid", "double", "770000 6277000 3\n770001 6277000 3\n", false},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        write_content(folder.path() / "a.ply", text_file("", c.rows, c.type));
        const Warnings warnings;
        const PlySource source(folder.path() / "a.ply");
        const std::string text = warnings.text();
        CHECK(std::count(text.begin(), text.end(), '\n') == (c.warned ? 1 : 0));
        if (c.warned)
            CHECK_THAT(text, contains("32-bit float"));
    }
}

TEST_CASE("any single wrong byte gives points or an error, never anything else",
          "[voxelserver][ply]") {
    const PlyKind kind = GENERATE(PlyKind::kText, PlyKind::kLittle);
    const TemporaryFolder folder;
    const std::string good = ply_bytes(made_points(4, 3), kind, "crs EPSG:2154");
    std::mt19937 random(11);
    for (std::size_t at = 0; at < good.size(); ++at) {
        std::string bytes = good;
        bytes[at] = static_cast<char>(random());
        write_content(folder.path() / "a.ply", bytes);
        INFO("byte " << at << " is " << static_cast<int>(bytes[at]));
        try {
            const PlySource source(folder.path() / "a.ply");
            CHECK(read_all(source).size() == source.info().point_count);
        } catch (const util::Error&) {  // the right answer to a damaged file
        }
    }
}
