#include "common/voxel/side_car.hpp"

#include <fstream>
#include <sstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::voxel;
using terravox::test::contains;

namespace {

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
    std::ifstream in(folder.path() / "car.json");
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

}  // namespace

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
        std::string text = written(example());
        const auto at = text.find(c.from);
        REQUIRE(at != std::string::npos);
        text.replace(at, std::string(c.from).size(), c.to);
        CHECK_THROWS_WITH(side_car_from_json(text, "car.json"), contains(c.said));
        CHECK_THROWS_AS(side_car_from_json(text, "car.json"), util::Error);
    }
}
