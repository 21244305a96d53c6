#include <optional>

#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/make/voxelize/columns/point_set.hpp"
#include "voxelserver/make/voxelize/columns/square_reader.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

/// Land of 400 x 400 m of which only the margin has points, in a file of its own.
class Margin {
public:
    explicit Margin(std::size_t memory_bytes = std::size_t{1} << 30) {
        Cloud cloud;
        cloud.cover(0, 0, 400, 400, 0.5, 2, [](double e, double n) {
            const bool outside = std::max(std::abs(e - 200), std::abs(n - 200)) > 190;
            return outside ? 100.5 : kNoHeight;
        });
        cloud.write(m_folder.path() / "margin.laz");
        auto options = OpenWorld::with(m_folder.path() / "margin.laz");
        options.memory_bytes = memory_bytes;
        m_points.emplace(options, m_settings, m_times);
    }
    [[nodiscard]] PointSet& points() { return *m_points; }
    [[nodiscard]] std::uint64_t decoded() const {
        for (const auto& stage : m_times.stages())
            if (stage.name == "point load")
                return stage.count;
        return 0;
    }

private:
    TemporaryFolder m_folder;
    util::StageTimes m_times;
    Settings m_settings;
    std::optional<PointSet> m_points;
};

grid::PatchKey patch_at(double east, double north) {
    return {voxel_x(east) >> 6, voxel_z(north) >> 6};
}

SquareSource with_islands(std::vector<grid::ColumnRect> islands) {
    SquareSource out;
    out.islands = std::move(islands);
    return out;
}

/// Two files side by side, and one whose points lie in two places.
const std::vector<SquareSource> kFiles{
    with_islands({{0, 0, 100, 100}}),
    with_islands({{100, 0, 200, 100}}),
    with_islands({{-70, -70, -20, -10}, {5000, 5000, 5200, 5200}}),
};

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

TEST_CASE("a window decodes what it needs once, in however little memory",
          "[voxelserver][voxelize][points]") {
    Margin roomy;
    (void)roomy.points().window(patch_at(5, 200));
    const std::uint64_t whole = roomy.decoded();
    CHECK(whole > 0);
    Margin tight(1);
    (void)tight.points().window(patch_at(5, 200));
    CHECK(tight.decoded() <= 2 * whole);  // once to learn which part holds what
}

TEST_CASE("patches inside the bounds without a point are one and the same, and are covered",
          "[voxelserver][voxelize][points]") {
    Margin land;
    const auto empty = land.points().columns(patch_at(150, 150));
    CHECK_FALSE(empty->any);
    CHECK(land.points().columns(patch_at(250, 250)) == empty);
    for (const water::WaterCell& cell : empty->cells.cells)
        CHECK(cell.covered);
}

TEST_CASE("a patch outside the bounds is empty and not covered",
          "[voxelserver][voxelize][points]") {
    Margin land;
    const grid::PatchKey far_away = patch_at(900, 900);
    const auto outside = land.points().columns(far_away);
    REQUIRE(outside);
    CHECK_FALSE(outside->any);
    for (const water::WaterCell& cell : outside->cells.cells)
        CHECK_FALSE(cell.covered);
    CHECK(land.points().in_bounds(far_away).at(32, 32) == 0);
    CHECK(land.points().in_bounds(patch_at(200, 200)).at(32, 32) == 1);
}

TEST_CASE("bounds are half-open, and each part of them counts", "[voxelserver][voxelize][bounds]") {
    const SurveyBounds bounds(kFiles);
    struct Case {
        std::int32_t x;
        std::int32_t z;
        bool inside;
    };
    for (const Case& c :
         {Case{0, 0, true}, Case{99, 99, true}, Case{100, 50, true}, Case{199, 50, true},
          Case{200, 50, false}, Case{-1, 0, false}, Case{50, 100, false}, Case{-70, -70, true},
          Case{-20, -20, false}, Case{5100, 5100, true}, Case{2000, 2000, false}}) {
        INFO(c.x << " " << c.z);
        CHECK(bounds.contains(c.x, c.z) == c.inside);
    }
}

TEST_CASE("a rectangle is surrounded where one part of the bounds holds all of it",
          "[voxelserver][voxelize][bounds]") {
    const SurveyBounds bounds(kFiles);
    CHECK(bounds.surrounds({0, 0, 100, 100}));
    CHECK(bounds.surrounds({10, 20, 30, 40}));
    CHECK_FALSE(bounds.surrounds({0, 0, 101, 100}));
    CHECK_FALSE(bounds.surrounds({90, 0, 110, 10}));  // two files hold it together
    CHECK_FALSE(bounds.surrounds({300, 300, 310, 310}));
    CHECK_FALSE(SurveyBounds(std::span<const SquareSource>{}).surrounds({0, 0, 1, 1}));
}

TEST_CASE("the window around a patch has what contains() says of each column",
          "[voxelserver][voxelize][bounds]") {
    const SurveyBounds bounds(kFiles);
    for (const grid::PatchKey middle :
         {grid::PatchKey{0, 0}, grid::PatchKey{1, 1}, grid::PatchKey{-2, -1},
          grid::PatchKey{78, 79}, grid::PatchKey{40, 40}}) {
        INFO(middle.px << " " << middle.pz);
        const auto inside = bounds.around(middle);
        int wrong = 0;
        Grid<char, Window::kMargin>::each([&](int x, int z) {
            const bool wanted = bounds.contains(middle.x0() + x, middle.z0() + z);
            wrong += inside.at(x, z) == (wanted ? 1 : 0) ? 0 : 1;
        });
        CHECK(wrong == 0);
    }
}

TEST_CASE("a file that was decoded whole is reported and counted once",
          "[voxelserver][voxelize][report]") {
    Fixture f;
    const auto counts = make_counts({2, 40, 40, 255}, 3);
    f.report.add_whole(0, counts);
    f.report.add_whole(0, counts);
    CHECK(f.log.text() ==
          "a.laz: stray points, outside the bounds of all others; left out (3 points)\n"
          "a.laz: points of classes that the class table small does not name (40, 255): shown in "
          "magenta\n");
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
    CHECK(f.log.count("47 and 2 more)") == 1);
    CHECK(f.log.count("48") == 0);
    util::say_shared_warnings();
    f.report.add_part(1, make_counts({64}));
    CHECK(f.log.count("b.laz: points of classes") == 1);
    CHECK(f.log.count("(64): shown in magenta; --classes that names them: fr-lidarhd") == 1);
}

TEST_CASE("what is met in parts is logged once for each file, what files share in one line",
          "[voxelserver][voxelize][report]") {
    Fixture f;
    f.report.add_part(0, make_counts({2, 40}));
    f.report.add_part(0, make_counts({40, 41}, 2));
    f.report.add_part(0, make_counts({41}, 1));
    CHECK(f.log.text() ==
          "a.laz: points of classes that the class table small does not name (40): shown in "
          "magenta\n"
          "a.laz: stray points, outside the bounds of all others; left out\n"
          "a.laz: points of classes that the class table small does not name (41): shown in "
          "magenta\n");
    f.report.add_part(1, make_counts({40}));
    CHECK(f.log.count("b.laz") == 0);
    util::say_shared_warnings();
    CHECK(f.log.count("b.laz: points of classes that") == 1);
    CHECK(f.report.counts().kept == 0);
}

TEST_CASE("classes that only later files have are named, with the tables that name them",
          "[voxelserver][voxelize][report]") {
    Fixture f;
    f.report.add_whole(0, make_counts({64}));
    const std::string before = f.log.text();
    f.report.add_whole(1, make_counts({64, 65, 66}));
    CHECK(f.log.text().substr(before.size()) ==
          "b.laz: points of classes that the class table small does not name (65, 66): shown in "
          "magenta; --classes that names them: fr-lidarhd\n");
    util::say_shared_warnings();
    CHECK(f.log.count("b.laz: points of classes that the class table small does not name (64)") ==
          1);
}
