#include "voxelserver/make/voxelize/columns/square_reader.hpp"

#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

/// Two files, and a table that names the classes below 40.
struct Fixture {
    Fixture() {
        files[0].info.path = "a.laz";
        files[1].info.path = "b.laz";
        classes.id = "small";
        for (std::size_t c = 0; c < 40; ++c)
            classes.meaning[c].known = true;
    }
    std::vector<SquareSource> files = std::vector<SquareSource>(2);
    ClassTable classes;
    Warnings log;
    LoadReport report{files, classes};
};

store::PointCounts make_counts(const std::vector<int>& classes, std::uint64_t stray = 0) {
    store::PointCounts out;
    out.outliers = stray;
    for (const int c : classes) {
        ++out.by_class[static_cast<std::size_t>(c)];
        ++out.kept;
    }
    return out;
}

}  // namespace

TEST_CASE("a file that was decoded whole is reported and counted once",
          "[voxelserver][voxelize][report]") {
    Fixture f;
    const auto counts = make_counts({2, 40, 40, 255}, 3);
    f.report.add_whole(0, counts);
    f.report.add_whole(0, counts);
    CHECK(f.log.text() ==
          "a.laz: 3 stray points, outside the bounds of all others; left out\n"
          "a.laz: classes that the table 'small' does not name: 40 (2 points), 255 (1 points); "
          "shown as `unknown`\n");
    CHECK(f.report.counts().kept == 4);
    CHECK(f.report.counts().outliers == 3);
    f.report.add_whole(1, make_counts({2}));
    CHECK(f.report.counts().kept == 5);
    CHECK(f.report.counts().by_class[2] == 2);
    CHECK(f.log.count("b.laz") == 0);
}

TEST_CASE("of many unknown classes eight are named, and tables that name them all",
          "[voxelserver][voxelize][report]") {
    Fixture f;
    f.report.add_whole(0, make_counts({40, 41, 42, 43, 44, 45, 46, 47, 48, 49}));
    CHECK(f.log.count("47 (1 points) and 2 more; shown") == 1);
    CHECK(f.log.count("48") == 0);
    f.report.add_part(1, make_counts({64}));
    CHECK(f.log.count("b.laz: class 64, which the table 'small' does not name; shown as "
                      "`unknown`; tables that name them (--classes): fr-lidarhd") == 1);
}

TEST_CASE("what is met in parts is logged once for each file, without its number",
          "[voxelserver][voxelize][report]") {
    Fixture f;
    f.report.add_part(0, make_counts({2, 40}));
    f.report.add_part(0, make_counts({40, 41}, 2));
    f.report.add_part(0, make_counts({41}, 1));
    CHECK(f.log.text() ==
          "a.laz: class 40, which the table 'small' does not name; shown as `unknown`\n"
          "a.laz: stray points, outside the bounds of all others; left out\n"
          "a.laz: class 41, which the table 'small' does not name; shown as `unknown`\n");
    f.report.add_part(1, make_counts({40}));
    CHECK(f.log.count("b.laz: class 40") == 1);
    CHECK(f.report.counts().kept == 0);
}
