#include <algorithm>

#include "common/util/error.hpp"
#include "tests/common/full_disk.hpp"
#include "tests/voxelserver/tools/survey/survey_fixture.hpp"
#include "voxelserver/data/lidar/las_writer.hpp"
#include "voxelserver/tools/survey/square_model.hpp"
#include "voxelserver/tools/survey/survey_options.hpp"

using namespace terravox;
using namespace terravox::survey;
using namespace terravox::lidar;
using namespace terravox::survey::test;

namespace {

std::optional<SurveyOptions> parsed(std::vector<const char*> arguments) {
    arguments.insert(arguments.begin(), "terravox-survey");
    std::optional<int> exit_code;
    return parse_options(static_cast<int>(arguments.size()), arguments.data(), exit_code);
}

SquareExtent middle_of_the_place() {
    return {462240, 101232, 512};
}

}  // namespace

TEST_CASE("values out of range are usage errors that name option, value and range",
          "[survey][options]") {
    struct Case {
        const char* option;
        const char* value;
    };
    const auto c = GENERATE(values<Case>({
        {"--density", "0.05"},     {"--density", "201"},
        {"--density", "nan"},      {"--density", "8x"},
        {"--squares", "0x1"},      {"--squares", "1x101"},
        {"--squares", "3"},        {"--squares", "2x2x2"},
        {"--seed", "-1"},          {"--seed", "18446744073709551616"},
        {"--seed", "seven"},       {"--square-m", "100"},
        {"--square-m", "48"},      {"--square-m", "1008"},
        {"--origin", "462"},       {"--origin", "462.0005,101"},
        {"--origin", "-1,101"},    {"--threads", "-1"},
        {"--photo-sun", "150"},    {"--photo-sun", "150,5"},
        {"--photo-sun", "361,40"}, {"--photo-sun", "150,nan"},
        {"--photo-haze", "0.5"},   {"--photo-clouds", "0.5"},
    }));
    DYNAMIC_SECTION(c.option << " " << c.value) {
        const std::string joined = std::string(c.option) + "=" + c.value;
        try {
            parsed({joined.c_str(), "-o", "x"});
            FAIL("accepted");
        } catch (const util::UsageError& error) {
            CHECK(std::string(error.what()).find(c.option) != std::string::npos);
            CHECK(error.exit_code() == util::ExitCode::kUsage);
        }
    }
}

TEST_CASE("unknown flags and a missing folder are usage errors", "[survey][options]") {
    CHECK_THROWS_AS(parsed({"--colour", "-o", "x"}), util::UsageError);
    CHECK_THROWS_AS(parsed({"--seed", "3"}), util::UsageError);
}

TEST_CASE("the command line of the manual is understood", "[survey][options]") {
    const auto options =
        parsed({"--seed", "9", "--squares", "2x3", "--density", "0.5", "-o", "out"});
    REQUIRE(options);
    CHECK(options->seed == 9);
    CHECK(options->density == 0.5);
    const auto squares = list_squares(*options);
    REQUIRE(squares.size() == 6);
    CHECK(squares.front().name() == "TM_462_101");
    CHECK(squares.back().name() == "TM_463_103");
}

TEST_CASE("the light of the photograph is that of the options", "[survey][options]") {
    CHECK_FALSE(parsed({"-o", "out"})->photo_light);
    const auto options = parsed({"--photo-sun", "150,40.5", "--photo-haze", "0.25", "-o", "out"});
    REQUIRE(options);
    REQUIRE(options->photo_light);
    CHECK(options->photo_light->azimuth_deg == 150);
    CHECK(options->photo_light->altitude_deg == 40.5);
    CHECK(options->photo_light->haze == 0.25);
    CHECK(options->photo_light->clouds == 0);
    CHECK_THROWS_AS(parsed({"--photo-sun", "150,40", "--photo-haze", "2", "-o", "out"}),
                    util::UsageError);
}

TEST_CASE("a small square starts around the middle of the place, on a multiple of 16 m",
          "[survey][options]") {
    const auto options = parsed({"--square-m", "512", "-o", "out"});
    REQUIRE(options);
    CHECK(list_squares(*options).front().name() == "TM_462240_101232");
    const auto placed = parsed({"--square-m", "256", "--origin", "463.5,102.25", "-o", "out"});
    REQUIRE(placed);
    CHECK(list_squares(*placed).front().name() == "TM_463500_102250");
}

TEST_CASE("neighbouring squares agree on everything near their edge", "[survey][model]") {
    const SquareExtent west{462512, 101300, 128};
    const SquareExtent east{462640, 101300, 128};
    const SquareModel a(7, west, 1), b(7, east, 1);
    const double edge = east.box().x0;
    const double south = east.box().y0;
    int differences = 0;
    for (double dx = -30; dx <= 30; dx += 1.7)
        for (double dy = 0; dy < 128; dy += 2.3) {
            const Vec2 p{edge + dx, south + dy};
            differences += a.ground_m(p) != b.ground_m(p);
            differences += a.water_m(p) != b.water_m(p);
            differences += a.cover(p) != b.cover(p);
            differences += a.road_edge_m(p) != b.road_edge_m(p);
        }
    CHECK(differences == 0);

    const Box2 shared{edge - 30, south, edge + 30, south + 128};
    const auto trees_in = [&](const SquareModel& model) {
        std::vector<std::pair<double, double>> out;
        for (const Tree& tree : model.trees())
            if (shared.contains(tree.at))
                out.emplace_back(tree.at.x, tree.height_m);
        std::sort(out.begin(), out.end());
        return out;
    };
    const auto buildings_in = [&](const SquareModel& model) {
        std::vector<std::pair<double, double>> out;
        for (const Building& building : model.buildings())
            if (building.bounds().overlaps(shared))
                out.emplace_back(building.centre.x, building.ridge_m);
        std::sort(out.begin(), out.end());
        return out;
    };
    CHECK_FALSE(trees_in(a).empty());
    CHECK_FALSE(buildings_in(a).empty());
    CHECK(trees_in(a) == trees_in(b));
    CHECK(buildings_in(a) == buildings_in(b));
}

TEST_CASE("the place has what its description promises, for any seed", "[survey][model]") {
    const std::uint64_t seed =
        GENERATE(std::uint64_t{7}, std::uint64_t{1}, std::uint64_t{20260621});
    CAPTURE(seed);
    const SquareModel model(seed, middle_of_the_place(), 2);
    const Site* place = nullptr;
    for (const Site& site : model.terrain().sites())
        if (site.is_the_place())
            place = &site;
    REQUIRE(place != nullptr);
    REQUIRE((place->lake && place->island && place->castle && place->brook));

    CHECK(model.water_m(place->lake->centre + Vec2{30, -30}) == kLakeLevel_m);
    CHECK_FALSE(model.water_m(place->island->centre).has_value());
    CHECK(model.ground_m(place->island->centre) > kLakeLevel_m + 5);
    CHECK(model.ground_m(place->castle->centre) > kLakeLevel_m + 60);

    int houses = 0;
    int castle = 0;
    int church = 0;
    for (const Building& building : model.buildings()) {
        houses += building.use == BuildingUse::kHouse;
        castle += building.use == BuildingUse::kCastle;
        church += building.use == BuildingUse::kChurch;
        CHECK(building.eaves_m > building.ground_m + 1.5);
        CHECK(building.ridge_m >= building.eaves_m);
        CHECK_FALSE(
            (building.use == BuildingUse::kHouse && model.water_m(building.centre).has_value()));
    }
    CHECK(houses > 30);
    CHECK(castle > 12);
    CHECK(church >= 5);

    const auto& bridges = model.roads().bridges;
    CHECK(std::any_of(bridges.begin(), bridges.end(), [](const Bridge& b) {
        return b.deck_m > b.water_m + 4.0 && b.half_width_m > 3.0;
    }));
}

TEST_CASE("water falls along the river and houses do not overlap", "[survey][model]") {
    const River river(7, 0);
    for (double x = -50000; x < 50000; x += 100)
        CHECK(river.level_m(x + 100) < river.level_m(x));

    const SquareModel model(7, {462640, 101300, 256}, 1);
    int overlaps = 0;
    const auto& all = model.buildings();
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t k = i + 1; k < all.size(); ++k) {
            const bool separate =
                all[i].use == BuildingUse::kFarm && all[k].use == BuildingUse::kFarm;
            if (separate && footprints_overlap(all[i], all[k], 0))
                ++overlaps;
        }
    CHECK(overlaps == 0);
}

TEST_CASE("a writer that is not closed leaves nothing behind", "[las_writer]") {
    const TemporaryFolder folder;
    {
        LasWriter writer(folder.path() / "a.laz", {});
        writer.write({});
        CHECK_FALSE(std::filesystem::exists(folder.path() / "a.laz"));
    }
    CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("a full disk is reported, however little of the file is missing", "[las_writer]") {
    const char* const extension = GENERATE(".las", ".laz");
    const TemporaryFolder folder;
    const auto write = [&](const std::filesystem::path& path) {
        LasWriter writer(path, {});
        for (int i = 0; i < 500; ++i) {
            LasWritePoint point;
            point.x = i;
            point.y = i * 7919 % 500;
            point.z = i * 104729 % 500;
            writer.write(point);
        }
        writer.close();
    };
    const auto good = folder.path() / (std::string("good") + extension);
    write(good);
    const auto whole = static_cast<rlim_t>(std::filesystem::file_size(good));
    const auto path = folder.path() / (std::string("full") + extension);
    for (const rlim_t room : {rlim_t{0}, rlim_t{100}, whole / 2, whole - 1}) {
        CAPTURE(room, whole);
        const terravox::test::FullDisk disk(room);
        CHECK_THROWS_WITH(write(path), terravox::test::contains("write " + path.string()));
        CHECK_FALSE(std::filesystem::exists(path));
    }
}

TEST_CASE("what a LAS file cannot hold is refused", "[las_writer]") {
    const TemporaryFolder folder;
    LasWriterOptions options;
    options.point_format = 4;
    CHECK_THROWS_AS(LasWriter(folder.path() / "a.laz", options), util::UsageError);
    options.point_format = 6;
    LasWriter writer(folder.path() / "a.laz", options);
    LasWritePoint point;
    point.x = 1e12;
    CHECK_THROWS_WITH(writer.write(point), terravox::test::contains("does not fit"));
    point = {};
    point.return_number = 3;
    point.return_count = 2;
    CHECK_THROWS_WITH(writer.write(point), terravox::test::contains("return 3 of 2"));
    options.point_format = 1;
    LasWriter old(folder.path() / "b.las", options);
    point = {};
    point.classification = 40;
    CHECK_THROWS_WITH(old.write(point), terravox::test::contains("class 40"));
}
