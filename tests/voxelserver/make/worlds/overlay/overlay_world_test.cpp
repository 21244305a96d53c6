#include "voxelserver/make/worlds/overlay/overlay_world.hpp"

#include <fstream>
#include <stdexcept>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/common/voxel/array_world.hpp"
#include "tests/voxelserver/make/worlds/voxels.hpp"

namespace {

using namespace terravox;
using overlay::Footprint;
using test::ArrayWorld;
using test::contains;
using test::Voxels;
using voxel::Material;

/// Ground up to y = 0, a tree and a house on it, and a column without data.
std::unique_ptr<ArrayWorld> land(int level = 0) {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-100, -4, -100},
                                              ArrayWorld::Coord{100, 12, 100}, level);
    world->fill({-100, -4, -100}, {100, 0, 100}, Material::kGrass);
    world->fill({-51, -4, -51}, {-50, 0, -50}, Material::kAir);
    world->fill({20, 0, 20}, {21, 3, 21}, Material::kTrunk);
    world->fill({18, 3, 18}, {23, 8, 23}, Material::kHighVegetation);
    world->fill({40, 0, 40}, {50, 6, 50}, Material::kRoof);
    return world;
}

std::unique_ptr<voxel::World> with(std::vector<std::string> additions, int level = 0) {
    return overlay::with_additions(land(level), additions);
}

/// The land with what a GeoJSON file of these members adds.
std::unique_ptr<voxel::World> with_file(const std::string& members, int level = 0) {
    const test::TemporaryFolder folder;
    const std::vector<std::string> additions{(folder.path() / "plan.geojson").string()};
    std::ofstream(additions[0]) << R"({"crs":{"properties":{"name":"EPSG:3794"}},)" << members
                                << "}";
    auto base = land(level);
    base->editable_info().crs = "EPSG:3794";
    base->editable_info().crs_wkt = geo::Crs::from_text("EPSG:3794").wkt();
    return overlay::with_additions(std::move(base), additions);
}

}  // namespace

TEST_CASE("a footprint contains what is inside of its border and outside of its holes",
          "[voxelserver][overlay]") {
    const Footprint f(
        {{{0, 0}, {10, 0}, {10, 10}, {0, 10}, {0, 0}}, {{4, 4}, {6, 4}, {6, 6}, {4, 6}}});
    CHECK(f.contains(1, 1));
    CHECK(f.contains(9.5, 5));
    CHECK_FALSE(f.contains(5, 5));
    CHECK_FALSE(f.contains(11, 5));
    CHECK_FALSE(f.contains(5, -1));
    CHECK(f.contains(f.middle()[0], f.middle()[1]));
    CHECK_THROWS_AS(Footprint({}), std::invalid_argument);
    CHECK_THROWS_AS(Footprint({{{0, 0}, {1, 1}}}), std::invalid_argument);
    CHECK_THROWS_AS(Footprint({{{0, 0}, {5, 0}, {9, 0}}}), std::invalid_argument);
}

TEST_CASE("a planned object is solid, and all else is as it was", "[voxelserver][overlay]") {
    const auto before = land();
    const auto after = with({"-10,-70,5,-60,300"});
    CHECK(after->info().bounds.max[1] == 300);
    CHECK(after->column(0, -1, -1).by_end == 2);
    Voxels voxels(*after);
    for (int z = -100; z < 100; ++z)
        for (int x = -100; x < 100; ++x)
            for (const int y : {-4, -1, 0, 5, 11, 12, 255, 256, 299, 300}) {
                const bool is_inside = x >= -10 && x < 5 && z >= -70 && z < -60 && y < 300;
                const auto there = voxels.at(x, y, z);
                if (is_inside) {
                    if (!there)
                        FAIL("air at " << x << ", " << y << ", " << z);
                    continue;
                }
                const Material wanted = before->at(x, y, z);
                const bool is_air = wanted == Material::kAir;
                if (is_air == there.has_value() ||
                    (there && there->material != wanted && there->material != Material::kRock))
                    FAIL("another voxel at " << x << ", " << y << ", " << z);
            }
    const auto wall = voxels.at(-10, 100, -65);
    REQUIRE(wall);
    CHECK(wall->material == Material::kPlain);
    const auto untouched = after->box({0, 1, -1, 1});
    CHECK(untouched->checksum() == before->box({0, 1, -1, 1})->checksum());
    CHECK(after->edition() != with({"-10,-70,5,-60,301"})->edition());
    CHECK(after->may_hold({{0, -1, 1, -1}, {0, 0, 2, 0}}));
}

TEST_CASE("an added tower is typical of its place", "[voxelserver][overlay]") {
    auto base = land();
    base->editable_info().bounds.max[1] = 900;
    base->editable_info().typical_heights = voxel::HeightRange{-4, 12};
    const std::vector<std::string> tower{"-10,-70,5,-60,300"};
    const auto after = overlay::with_additions(std::move(base), tower);
    CHECK(after->info().bounds.max[1] == 900);
    CHECK(after->info().typical_heights == voxel::HeightRange{-4, 300});
}

TEST_CASE("on coarse levels an object keeps its place, and never vanishes",
          "[voxelserver][overlay]") {
    // Voxels of 8; the array's coordinates are in these.
    const auto world = with({"80,80,160,160,80", "-799,-799,-798,-798,80"}, 3);
    Voxels voxels(*world, 3);
    for (int z = 0; z < 30; ++z)
        for (int x = 0; x < 30; ++x) {
            const bool is_inside = x >= 10 && x < 20 && z >= 10 && z < 20;
            const auto there = voxels.at(x, 9, z);
            CHECK(there.has_value() == is_inside);
        }
    CHECK(voxels.at(-100, 9, -100).has_value());
    CHECK_FALSE(voxels.at(-99, 9, -100).has_value());
}

TEST_CASE("boxes asked for together are those asked for alone", "[voxelserver][overlay]") {
    const auto world = with({"-10,-10,5,5,40"});
    const std::vector<voxel::BoxKey> keys = {{0, -1, 0, -1}, {0, 0, 0, 0}, {0, 1, -1, 1}};
    int count = 0;
    world->boxes(keys, [&](const voxel::BoxKey& key, const voxel::BoxOutcome& outcome) {
        ++count;
        CHECK(outcome.box->checksum() == world->box(key)->checksum());
    });
    CHECK(count == 3);
}

TEST_CASE("heights count from the ground in the middle of an object", "[voxelserver][overlay]") {
    const auto world = land();
    CHECK(overlay::find_ground(*world, 0, 0) == 0);
    CHECK(overlay::find_ground(*world, 22, 22) == 0);  // below a crown
    CHECK(overlay::find_ground(*world, 45, 45) == 0);  // below a house
    CHECK(overlay::find_surface(*world, 45, 45)->top == 6);
    CHECK(with({"21,21,24,24,+30"})->info().bounds.max[1] == 30);
    CHECK(with({"42,42,48,48,+30"})->info().bounds.max[1] == 30);
}

TEST_CASE("polygons of a file are put into the world", "[voxelserver][overlay]") {
    const auto world = with_file(R"("type":"Feature","properties":{"height":20},"geometry":)"
                                 R"({"type":"Polygon","coordinates":[[[0,0],[9,0],[9,9],[0,0]]]})");
    CHECK(world->info().bounds.max[1] == 20);
    Voxels voxels(*world);
    CHECK(voxels.at(6, 15, -2).has_value());  // north of the southern border
    CHECK_FALSE(voxels.at(2, 15, -6).has_value());
    CHECK_FALSE(voxels.at(6, 15, 2).has_value());
}

TEST_CASE("points of a file are street lamps", "[voxelserver][overlay]") {
    const auto make_world = [](const std::string& points, int level = 0) {
        return with_file(R"("type":"FeatureCollection","features":[)" + points + "]", level);
    };
    const auto feature = [](const char* properties, const char* geometry) {
        return std::string(R"({"type":"Feature","properties":)") + properties + R"(,"geometry":)" +
               geometry + "}";
    };
    const auto world =
        make_world(feature("{}", R"({"type":"Point","coordinates":[10.3,-30.6]})") + "," +
                   feature(R"({"height":7.4})",
                           R"({"type":"MultiPoint","coordinates":[[-5,20],[45.5,-45.5]]})") +
                   "," + feature(R"({"top":9})", R"({"type":"Point","coordinates":[-5,-5]})"));
    Voxels voxels(*world);
    struct Case {
        int x, z, ground, top;
    };
    // One stands on a house.
    for (const Case& c :
         {Case{10, 30, 0, 5}, Case{-5, -20, 0, 7}, Case{45, 45, 6, 13}, Case{-5, 5, 0, 9}}) {
        INFO("lamp at " << c.x << ", " << c.z);
        for (int y = c.ground; y < c.top; ++y) {
            REQUIRE(voxels.at(c.x, y, c.z));
            CHECK(voxels.at(c.x, y, c.z)->material ==
                  (y == c.top - 1 ? Material::kLamp : Material::kPlain));
        }
        CHECK_FALSE(voxels.at(c.x, c.top, c.z));
        CHECK_FALSE(voxels.at(c.x + 1, c.top - 1, c.z));
        CHECK_FALSE(voxels.at(c.x, c.top - 1, c.z - 1));
    }
    const char* const square =
        R"({"type":"Polygon","coordinates":[[[9,-31],[12,-31],[12,-29],[9,-29],[9,-31]]]})";
    const std::string lamp = feature("{}", R"({"type":"Point","coordinates":[10.3,-30.6]})");
    const auto highest = [&](const char* properties) {
        const auto both = make_world(lamp + "," + feature(properties, square));
        return Voxels(*both).at(10, 4, 30)->material;
    };
    CHECK(highest(R"({"top":3})") == Material::kLamp);
    CHECK(highest(R"({"top":5})") == Material::kLamp);
    CHECK(highest(R"({"top":6})") == Material::kPlain);
    // A town has more lamps than the data, and OpenStreetMap writes numbers as texts.
    const auto town =
        make_world(feature("{}", R"({"type":"Point","coordinates":[400,0]})") + "," +
                   feature(R"({"height":"8 m"})", R"({"type":"Point","coordinates":[-5,20]})") +
                   "," + feature(R"({"height":"6"})", R"({"type":"Point","coordinates":[-5,-5]})"));
    Voxels of_town(*town);
    CHECK(of_town.at(-5, 7, -20)->material == Material::kLamp);
    CHECK(of_town.at(-5, 5, 5)->material == Material::kLamp);
    CHECK_THROWS_WITH(make_world(feature("{}", R"({"type":"Point","coordinates":[400,0]})")),
                      contains("it lies outside of the data; allowed: within -100,"));
    const std::string above_nothing =
        feature("{}", R"({"type":"Point","coordinates":[-50.5,50.5]})");
    const auto with_gap = make_world(above_nothing + "," + lamp);
    CHECK_FALSE(Voxels(*with_gap).at(-51, 4, -51));
    CHECK(Voxels(*with_gap).at(10, 4, 30)->material == Material::kLamp);
    // Where voxels are large, a lamp would be a glowing block.
    for (const int level : {2, 3}) {
        const auto coarse = make_world(
            feature(R"({"top":100})", R"({"type":"Point","coordinates":[10.3,-30.6]})"), level);
        CHECK(Voxels(*coarse, level).at(10 >> level, 90 >> level, 30 >> level).has_value() ==
              (level == 2));
    }
    CHECK_THROWS_WITH(
        make_world(feature("{}", R"({"type":"LineString","coordinates":[[0,0],[1,1]]})")),
        contains("feature 0 is neither a polygon nor a point"));
    CHECK_THROWS_WITH(make_world(""), contains("neither a polygon nor a point"));
}

TEST_CASE("plans that differ in a corner are different worlds", "[voxelserver][overlay]") {
    const auto make_edition = [](const std::string& ring) {
        return with_file(R"("type":"Feature","properties":{"top":20},"geometry":)"
                         R"({"type":"Polygon","coordinates":[)" +
                         ring + "]}")
            ->edition();
    };
    const std::string square = make_edition("[[0,0],[10,0],[10,10],[0,10],[0,0]]");
    CHECK(square == make_edition("[[0,0],[10,0],[10,10],[0,10],[0,0]]"));
    CHECK(square != make_edition("[[0,0],[10,0],[10,7],[7,10],[0,10],[0,0]]"));
}

TEST_CASE("what cannot be added is refused in words", "[voxelserver][overlay]") {
    struct Case {
        const char* text;
        const char* says;
    };
    for (const Case& c : {
             Case{"1,2,3,4", "allowed: west,south,east,north,TOP"},
             Case{"1,2,3,4,5,6", "allowed: west"},
             Case{"1,2,3,4,x", "allowed: west"},
             Case{"1,2,3,4,+", "allowed: west"},
             Case{"nan,2,3,4,5", "allowed: west"},
             Case{"tower", "allowed: west"},
             Case{"3,2,1,4,5", "upside down"},
             Case{"0,0,101,5,5", "within -100,-100,100,100"},
             Case{"0,0,10,5,1e6", "allowed: up to 20000"},
             Case{"plan.geojson", "no CRS"},
         }) {
        INFO(c.text);
        CHECK_THROWS_AS(with({c.text}), util::UsageError);
        CHECK_THROWS_WITH(with({c.text}), contains(c.says));
    }
    CHECK_THROWS_WITH(with(std::vector<std::string>(10'001, "0,0,2,2,5")),
                      contains("more than 10000 objects"));
}

TEST_CASE("adding objects ends when it is stopped", "[voxelserver][overlay]") {
    std::stop_source stop;
    const std::vector<std::string> additions{"-10,-70,5,-60,300"};
    const auto added = overlay::with_additions(land(), additions, stop.get_token());
    CHECK(added->info().bounds.max[1] == 300);
    stop.request_stop();
    CHECK_THROWS_WITH(overlay::with_additions(land(), additions, stop.get_token()),
                      contains("interrupted"));
}
