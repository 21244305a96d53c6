#include <limits>

#include "common/util/error.hpp"
#include "common/voxel/side_car.hpp"
#include "common/voxel/world.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::voxel;
using terravox::test::contains;
using terravox::test::replaced;

namespace {

WorldInfo full() {
    WorldInfo info;
    info.title = "Bled \"castle\" \\ č š ž";
    info.bounds = {{-5, -300, -101'000'000}, {462'000'000, 2864, 17}};
    info.voxel_m = 0.1;
    info.levels = 17;
    info.crs = "EPSG:3794";
    info.crs_wkt = "PROJCRS[\"Slovenia 1996 / Slovene National Grid\"]";
    info.crs_units_per_voxel = 1.0 / 3;
    info.centre = geo::MapPlace{{46.36364, 14.09366}, -1.0 / 3};
    info.licence = "CC BY 4.0";
    info.attribution = "ARSO\nline two";
    info.typical_heights = HeightRange{-20, 2600};
    return info;
}

SideCar example() {
    WorldInfo info;
    info.title = "Town";
    info.crs = "EPSG:3794";
    info.crs_wkt = "PROJCRS[]";
    info.voxel_m = 0.5;
    info.crs_units_per_voxel = 0.5;
    info.licence = "CC BY";
    info.attribution = "those who flew";
    info.centre = geo::MapPlace{{46, 14}, -0.72};
    SideCar car = make_side_car(info, 2, {512, -16, -1024});
    car.blocks = {{"minecraft:bricks", Material::kRoof}, {"minecraft:stone", Material::kRock}};
    return car;
}

std::string written(const SideCar& car) {
    const test::TemporaryFolder folder;
    write_side_car(folder.path() / "car.json", car);
    return test::read_content(folder.path() / "car.json");
}

}  // namespace

TEST_CASE("a world's description survives the way through JSON, to the last bit",
          "[common][voxel][world_json]") {
    const WorldInfo in = full();
    const WorldInfo out = world_from_json(world_to_json(in), "test");
    CHECK(out.title == in.title);
    CHECK(out.bounds == in.bounds);
    CHECK(out.voxel_m == in.voxel_m);
    CHECK(out.levels == in.levels);
    CHECK(out.crs == in.crs);
    CHECK(out.crs_wkt == in.crs_wkt);
    CHECK(out.crs_units_per_voxel == in.crs_units_per_voxel);
    REQUIRE(out.centre);
    CHECK(out.centre->lat_deg == in.centre->lat_deg);
    CHECK(out.centre->lon_deg == in.centre->lon_deg);
    CHECK(out.centre->convergence_deg == in.centre->convergence_deg);
    CHECK(out.licence == in.licence);
    CHECK(out.attribution == in.attribution);
    CHECK(out.typical_heights == in.typical_heights);
}

TEST_CASE("a world without typical heights has none in JSON, and those of no world are refused",
          "[common][voxel][world_json]") {
    WorldInfo plain = full();
    plain.typical_heights.reset();
    CHECK_FALSE(contains("typical").match(world_to_json(plain)));
    CHECK_FALSE(world_from_json(world_to_json(plain), "test").typical_heights);
    const std::string text = world_to_json(full());
    for (const char* heights : {"{\"max\":-20,\"min\":-20}", "{\"max\":1073741825,\"min\":0}",
                                "{\"max\":1,\"min\":-1073741825}", "{\"max\":1}", "5"}) {
        INFO(heights);
        const std::string bad = replaced(text, "{\"max\":2600,\"min\":-20}", heights);
        CHECK_THROWS_AS(world_from_json(bad, "test"), util::Error);
    }
}

TEST_CASE("a camera shows what is framed at typical heights, or all where nothing lies there",
          "[common][voxel]") {
    WorldInfo info;
    info.bounds = {{0, 0, 0}, {9, 500, 9}};
    CHECK(info.camera_bounds() == info.bounds);
    info.typical_heights = HeightRange{-10, 80};
    CHECK(info.camera_bounds() == VoxelBounds{{0, 0, 0}, {9, 80, 9}});
    CHECK(info.framed_bounds() == info.bounds);
    info.framed = {{2, 40, 2}, {5, 600, 5}};
    CHECK(info.camera_bounds() == VoxelBounds{{2, 40, 2}, {5, 80, 5}});
    info.framed.min[1] = 80;
    CHECK(info.camera_bounds() == info.framed);
}

TEST_CASE("where a world's centre does not say how its map is turned, north is true north",
          "[common][voxel][world_json]") {
    const std::string text = world_to_json(full());
    const std::string old = replaced(text, "\"convergence_deg\":-0.3333333333333333,", "");
    const WorldInfo out = world_from_json(old, "test");
    REQUIRE(out.centre);
    CHECK(out.centre->lat_deg == full().centre->lat_deg);
    CHECK(out.centre->convergence_deg == 0);
}

TEST_CASE("a world's centre beyond the Earth is refused", "[common][voxel][world_json]") {
    const std::string text = world_to_json(full());
    for (const char* lat : {"90.1", "-1e300", "\"46\"", "null"}) {
        INFO(lat);
        CHECK_THROWS_AS(world_from_json(replaced(text, "46.36364", lat), "test"), util::Error);
    }
    CHECK_THROWS_AS(world_from_json(replaced(text, "-0.3333333333333333", "1e9"), "test"),
                    util::Error);
}

TEST_CASE("a world that is nowhere on Earth has no centre on the other side either",
          "[common][voxel][world_json]") {
    WorldInfo in = full();
    in.centre.reset();
    in.crs.clear();
    in.crs_wkt.clear();
    CHECK_FALSE(world_from_json(world_to_json(in), "test").centre);
}

TEST_CASE("a title that is no UTF-8 does not break the reply", "[common][voxel][world_json]") {
    WorldInfo in = full();
    in.title = "caf\xe9";
    CHECK_NOTHROW(world_from_json(world_to_json(in), "test"));
}

TEST_CASE("text that is no world is refused, naming where it came from",
          "[common][voxel][world_json]") {
    const std::string good = world_to_json(full());
    struct Case {
        const char* name;
        std::string text;
        std::string said;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"nothing", "", "not the reply of a voxel server"},
        {"a web page", "<html><body>404</body></html>", "not the reply of a voxel server"},
        {"null", "null", "not the reply of a voxel server"},
        {"a list", "[]", "not the reply of a voxel server"},
        {"an empty object", "{}", "not the reply of a voxel server"},
        {"cut short", good.substr(0, good.size() / 2), "not the reply of a voxel server"},
        {"another version", replaced(good, "\"version\":2", "\"version\":3"),
         "version 3; allowed: 2"},
        {"a version that is text", replaced(good, "\"version\":2", "\"version\":\"2\""),
         "not the reply of a voxel server"},
        {"levels: none", replaced(good, "\"levels\":17", "\"levels\":0"), "levels = 0"},
        {"levels: too many", replaced(good, "\"levels\":17", "\"levels\":22"), "levels = 22"},
        {"voxels of no size", replaced(good, "\"voxel_m\":0.1", "\"voxel_m\":0"), "voxel_m = 0"},
        {"negative voxels", replaced(good, "\"voxel_m\":0.1", "\"voxel_m\":-1"), "voxel_m = -1"},
        {"voxels that are null (NaN)", replaced(good, "\"voxel_m\":0.1", "\"voxel_m\":null"),
         "not the reply of a voxel server"},
        {"bounds beyond 2^30", replaced(good, "462000000", "1073741825"), "bounds beyond 2^30"},
        {"bounds of two axes", replaced(good, "462000000,", ""), "not the reply of a voxel server"},
        {"boxes of another size", replaced(good, "[64,256,64]", "[32,256,32]"),
         "boxes of another size"},
        {"a title that is a number", replaced(good, "\"licence\":\"CC BY 4.0\"", "\"licence\":4"),
         "not the reply of a voxel server"},
        {"half a centre", replaced(good, "\"lat_deg\"", "\"latitude\""),
         "not the reply of a voxel server"},
        {"crs units of zero",
         replaced(good, "\"crs_units_per_voxel\":0.3333333333333333", "\"crs_units_per_voxel\":0"),
         "crs_units_per_voxel"},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK_THROWS_AS(world_from_json(c.text, "http://there:1"), util::Error);
        CHECK_THROWS_WITH(world_from_json(c.text, "http://there:1"),
                          contains("http://there:1") && contains(c.said));
    }
}

TEST_CASE("bounds that 32 bits cannot hold are refused and not cut",
          "[common][voxel][world_json]") {
    CHECK_THROWS_AS(
        world_from_json(replaced(world_to_json(full()), "462000000", "99999999999999"), "test"),
        util::Error);
}

TEST_CASE(
    "bounds that are too large for the levels of a world are refused: a picture of its air would "
    "never end",
    "[common][voxel][world_json]") {
    struct Case {
        const char* name;
        VoxelBounds bounds;
        int levels;
        bool allowed;
    };
    const auto c = GENERATE(values<Case>({
        {"as large as 32 bits can say, all levels",
         {{-(1 << 30), -(1 << 30), -(1 << 30)}, {1 << 30, 1 << 30, 1 << 30}},
         21,
         true},
        {"as large as 32 bits can say, one level",
         {{-(1 << 30), -(1 << 30), -(1 << 30)}, {1 << 30, 1 << 30, 1 << 30}},
         1,
         false},
        {"nothing", {{0, 0, 0}, {0, 0, 0}}, 1, true},
        {"2048 x 1 x 2048 boxes", {{0, 0, 0}, {131'072, 256, 131'072}}, 1, true},
        {"2048 x 1 x 2049 boxes", {{0, 0, 0}, {131'072, 256, 131'073}}, 1, false},
        {"the same with a level more", {{0, 0, 0}, {131'072, 256, 131'073}}, 2, true},
        {"a tower of 16384 boxes", {{0, 0, 0}, {64, 1 << 22, 64}}, 1, true},
        {"a tower of 16385 boxes", {{0, 0, 0}, {64, (1 << 22) + 1, 64}}, 1, false},
    }));
    DYNAMIC_SECTION(c.name) {
        WorldInfo info = full();
        info.bounds = c.bounds;
        info.levels = c.levels;
        if (c.allowed)
            CHECK(world_from_json(world_to_json(info), "http://there:1").bounds == c.bounds);
        else
            CHECK_THROWS_WITH(world_from_json(world_to_json(info), "http://there:1"),
                              contains("http://there:1") &&
                                  contains("boxes of the coarsest level; allowed: up to 16384"));
    }
}

TEST_CASE("a side-car is read back as it was written, in voxels of its level",
          "[common][voxel][side_car]") {
    const SideCar in = side_car_from_json(written(example()), "car.json");
    CHECK(in.world.title == "Town");
    CHECK(in.world.voxel_m == 2);
    CHECK(in.world.crs_units_per_voxel == 2);
    CHECK(in.offset == std::array<std::int32_t, 3>{512, -16, -1024});
    CHECK(in.blocks == example().blocks);
    REQUIRE(in.world.centre);
    CHECK(in.world.centre->lat_deg == 46);
    CHECK(in.world.centre->convergence_deg == -0.72);
    CHECK(in.world.crs == "EPSG:3794");
    CHECK(in.world.crs_wkt == "PROJCRS[]");
    CHECK(in.world.licence == "CC BY");
    CHECK(in.world.attribution == "those who flew");
}

TEST_CASE("a wrong side-car is refused by file and value", "[common][voxel][side_car]") {
    struct Case {
        const char *name, *from, *to, *said;
    };
    const auto c = GENERATE(values<Case>({
        {"another version", "\"version\": 1", "\"version\": 7", "version 7; allowed: 1"},
        {"no material", "\"roof\"", "\"cheese\"", "stands for 'cheese'"},
        {"an offset beyond", "512", "9876543210", "offset 9876543210"},
        {"an offset that is no number", "512", "\"far\"", "car.json"},
        {"voxels of nothing", "\"voxel_m\": 2.0", "\"voxel_m\": 0", "voxel_m = 0"},
        {"voxels of less", "\"crs_units_per_voxel\": 2.0", "\"crs_units_per_voxel\": -1",
         "crs_units_per_voxel"},
        {"not JSON", "{", "", "car.json"},
    }));
    DYNAMIC_SECTION(c.name) {
        const std::string text = test::replaced(written(example()), c.from, c.to);
        CHECK_THROWS_WITH(side_car_from_json(text, "car.json"), contains(c.said));
        CHECK_THROWS_AS(side_car_from_json(text, "car.json"), util::Error);
    }
}
