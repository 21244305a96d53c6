#include "voxelserver/make/voxelize/points/known_squares.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <random>

#include "common/util/error.hpp"
#include "common/voxel/fingerprint.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/voxelserver/make/voxelize/world/patchwork.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"

using namespace terravox;
using namespace terravox::test;
using voxelize::KnownSquare;
using voxelize::KnownSquares;

namespace {

/// Echoes of two flight lines, whose scale hangs on those of the files around.
std::filesystem::path with_echoes(const TemporaryFolder& folder, int changed = -1) {
    for (int i = 0; i < 4; ++i) {
        Cloud cloud;
        std::mt19937 random(static_cast<unsigned>(i) + (i == changed ? 50 : 1));
        for (int k = 0; k < 6000; ++k) {
            Cloud::Point point{};
            point.height = 300;
            point.source_class = 2;
            point.east = i * 300 + 0.5 + static_cast<double>(random() % 128'000) / 1000;
            point.north = static_cast<double>(random() % 128'000) / 1000;
            point.intensity = static_cast<std::uint16_t>(500 + random() % 3000);
            point.line = static_cast<std::uint16_t>(1 + random() % 2);
            cloud.add(point);
        }
        cloud.write(folder.path() / ("e" + std::to_string(i) + ".laz"));
    }
    return folder.path();
}

KnownSquares read_back(voxelize::LidarWorld& world, const voxel::Fingerprint& way) {
    return KnownSquares::from_bytes(world.known_squares({}), way);
}

voxel::Fingerprint usual_way() {
    return voxelize::way_of_opening(voxelize::load_settings("", "", "").points);
}

void check_same_world(const voxelize::LidarWorldOptions& with,
                      const voxelize::LidarWorldOptions& without) {
    OpenWorld a(with);
    OpenWorld b(without);
    CHECK(to_bytes(a.world().facts()) == to_bytes(b.world().facts()));
    CHECK(a.world().stats().flight_lines == b.world().stats().flight_lines);
    const Kept kept = keep(a.world());
    const Kept expected = keep(b.world());
    CHECK(std::equal(kept.boxes.begin(), kept.boxes.end(), expected.boxes.begin(),
                     expected.boxes.end(), [](const auto& one, const auto& other) {
                         return one.first == other.first &&
                                one.second.checksum == other.second.checksum &&
                                one.second.fingerprint == other.second.fingerprint;
                     }));
}

}  // namespace

TEST_CASE("a world opened with what is known of its files is the same",
          "[voxelserver][voxelize][known]") {
    Patchwork patchwork;
    const auto without = patchwork.options();
    auto with = without;
    with.known_squares = patchwork.root() / "squares.known";
    write_content(with.known_squares, OpenWorld(without).world().known_squares({}));
    SECTION("nothing has changed") {
        check_same_world(with, without);
    }
    SECTION("a square is another one, one is gone, one is new") {
        patchwork.write(2, [](Cloud::Point& p) { p.height += 40; });
        std::filesystem::remove(patchwork.square(5));
        patchwork.write(6);
        check_same_world(with, without);
    }
    SECTION("the CRS is set by hand") {
        auto other = without;
        other.crs = "EPSG:27572";
        auto other_with = with;
        other_with.crs = other.crs;
        check_same_world(other_with, other);
    }
    SECTION("the file is damaged, of other filters, or absent") {
        const std::string bytes = OpenWorld(without).world().known_squares({});
        write_content(with.known_squares, bytes.substr(0, bytes.size() / 2));
        check_same_world(with, without);
        std::filesystem::remove(with.known_squares);
        check_same_world(with, without);
    }
}

TEST_CASE("what is known of a file is believed", "[voxelserver][voxelize][known]") {
    const Patchwork patchwork;
    auto options = patchwork.options();
    OpenWorld world(options);
    KnownSquares known;
    known.roles = read_back(world.world(), usual_way()).roles;
    for (const auto& square : world.world().facts().squares) {
        KnownSquare one =
            *read_back(world.world(), usual_way())
                 .find(voxel::to_hex(voxel::file_identity(square.file, "point cloud")));
        one.max[2] += 1000;
        one.high += 1000;
        known.add(one);
    }
    options.known_squares = patchwork.root() / "squares.known";
    write_content(options.known_squares, known.to_bytes(usual_way()));
    CHECK(OpenWorld(options).info().bounds.max[1] >= world.info().bounds.max[1] + 999);
    // Not with another table of classes.
    auto other = options;
    other.classes = "de-nw";
    CHECK(OpenWorld(other).info().bounds.max[1] == world.info().bounds.max[1]);
    // Not of another way of opening.
    write_content(options.known_squares, known.to_bytes({1, 2}));
    CHECK(OpenWorld(options).info().bounds.max[1] == world.info().bounds.max[1]);
}

TEST_CASE("what could break arithmetic is not believed, whatever the checksum says",
          "[voxelserver][voxelize][known]") {
    const Patchwork patchwork;
    OpenWorld world(patchwork.options());
    const auto file = world.world().facts().squares.front().file;
    const KnownSquare good = *read_back(world.world(), usual_way())
                                  .find(voxel::to_hex(voxel::file_identity(file, "point cloud")));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    struct Case {
        const char* name;
        std::function<void(KnownSquare&)> spoil;
    };
    const std::vector<Case> cases = {
        {"as it was found", [](KnownSquare&) {}},
        {"no points", [](KnownSquare& s) { s.stated.point_count = 0; }},
        {"a height beyond all", [](KnownSquare& s) { s.low = -1e300; }},
        {"heights the wrong way round", [](KnownSquare& s) { std::swap(--s.low, s.high); }},
        {"bounds that overflow", [](KnownSquare& s) { s.bounds.max_x = 0x7fffffff; }},
        {"bounds of nothing", [](KnownSquare& s) { s.bounds.max_z = s.bounds.min_z; }},
        {"a rectangle without an end", [&](KnownSquare& s) { s.islands.front().max_x = nan; }},
        {"stated bounds that are none", [&](KnownSquare& s) { s.stated.min[1] = nan; }},
        {"a scale of nothing",
         [](KnownSquare& s) { s.brightness = voxelize::BrightnessScale({{1, 0.0}}); }},
    };
    for (const Case& c : cases) {
        INFO(c.name);
        KnownSquare spoilt = good;
        c.spoil(spoilt);
        KnownSquares one;
        one.add(spoilt);
        const std::string bytes = one.to_bytes(usual_way());
        if (&c == &cases.front())
            CHECK_NOTHROW(KnownSquares::from_bytes(bytes, usual_way()));
        else
            CHECK_THROWS_AS(KnownSquares::from_bytes(bytes, usual_way()), util::Error);
    }
}

TEST_CASE("the scale of intensities is known while no file near by has changed",
          "[voxelserver][voxelize][known]") {
    const TemporaryFolder folder;
    const TemporaryFolder elsewhere;
    auto without = OpenWorld::with(with_echoes(folder));
    auto with = without;
    with.known_squares = elsewhere.path() / "squares.known";
    {
        OpenWorld world(without);
        REQUIRE(world.world().stats().flight_lines == 2);
        write_content(with.known_squares, world.world().known_squares({}));
    }
    check_same_world(with, without);
    for (int changed = 0; changed < 4; ++changed) {
        with_echoes(folder, changed);
        check_same_world(with, without);
    }
}

TEST_CASE("files whose intensities mean something else than then are found",
          "[voxelserver][voxelize][known]") {
    using Files = std::set<std::size_t>;
    const TemporaryFolder folder;
    const TemporaryFolder elsewhere;
    auto options = OpenWorld::with(with_echoes(folder));
    options.known_squares = elsewhere.path() / "squares.known";
    const auto rescaled = [&](bool scales_are_known) {
        OpenWorld world(options);
        const std::vector<grid::ColumnRect> changed = {world.world().facts().squares.back().bounds};
        return world.world().rescaled_files(changed, scales_are_known);
    };
    write_content(options.known_squares, OpenWorld(options).world().known_squares({}));
    CHECK((rescaled(true) == Files{}));
    // Squares are 300 m apart, and share what lies within 500 m.
    CHECK((rescaled(false) == Files{1, 2, 3}));
    // The others are written again, the same, with the time that they had.
    const auto file = [&](int i) { return folder.path() / ("e" + std::to_string(i) + ".laz"); };
    const auto written = std::filesystem::last_write_time(file(0));
    for (int i = 0; i < 3; ++i)
        std::filesystem::last_write_time(file(i), written);
    write_content(options.known_squares, OpenWorld(options).world().known_squares({}));
    with_echoes(folder, 3);
    for (int i = 0; i < 3; ++i)
        std::filesystem::last_write_time(file(i), written);
    CHECK((rescaled(true) == Files{1, 2, 3}));
    CHECK((rescaled(false) == Files{1, 2, 3}));
    SECTION("not before it is noted") {
        write_content(options.known_squares, OpenWorld(options).world().known_squares({}));
        CHECK((rescaled(true) == Files{}));
    }
    SECTION("none where materials are not guessed") {
        options.steps = "-material_guesses";
        CHECK((rescaled(true) == Files{}));
        CHECK((rescaled(false) == Files{}));
    }
}

TEST_CASE("of two records of one file the first one counts", "[voxelserver][voxelize][known]") {
    KnownSquares known;
    KnownSquare square;
    square.identity = {0x0123456789abcdef, 0xfedcba9876543210};
    for (const double low : {1.0, 2.0, 3.0}) {
        square.low = low;
        known.add(square);
    }
    REQUIRE(known.find(square.identity) != nullptr);
    CHECK(known.find(square.identity)->low == 1);
    CHECK(known.find(square.identity, square.side_identity)->low == 1);
    CHECK(known.find(square.identity, {7, 7}) == nullptr);
    REQUIRE(known.find("0123456789abcdeffedcba9876543210") != nullptr);
    CHECK(known.find("0123456789abcdeffedcba9876543210")->low == 1);
    for (const char* other :
         {"", "0123", "0123456789abcdeffedcba987654321", "g123456789abcdeffedcba9876543210",
          "0123456789abcdeffedcba98765432100", "0123456789abcdeffedcba9876543211"})
        CHECK(known.find(std::string_view(other)) == nullptr);
}

TEST_CASE("what is known of files is refused when damaged", "[voxelserver][voxelize][known]") {
    const Patchwork patchwork;
    OpenWorld world(patchwork.options());
    const std::string bytes = world.world().known_squares({});
    const auto way = usual_way();
    CHECK(!KnownSquares::from_bytes(bytes, way).empty());
    CHECK_THROWS_AS(KnownSquares::from_bytes(bytes, {3, 4}), util::Error);
    for (std::size_t size = 0; size < bytes.size(); size += 7)
        CHECK_THROWS_AS(KnownSquares::from_bytes(bytes.substr(0, size), way), util::Error);
    std::mt19937 random(5);
    for (int i = 0; i < 200; ++i) {
        std::string damaged = bytes;
        damaged[random() % damaged.size()] ^= static_cast<char>(1U << (random() % 8));
        CHECK_THROWS_AS(KnownSquares::from_bytes(damaged, way), util::Error);
    }
}
