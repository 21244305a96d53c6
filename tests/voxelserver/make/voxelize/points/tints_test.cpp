// Which typical colours are meant for a place, and what buildings take of them.
#include "voxelserver/make/voxelize/points/tints.hpp"

#include <fstream>
#include <set>

#include "common/util/error.hpp"
#include "common/voxel/fingerprint.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;
using voxel::Material;

namespace {

Tints tints_from(const std::string& text) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "mine.toml";
    std::ofstream(file) << text;
    return Tints::load(file.string());
}

using Colours = std::set<std::array<int, 3>>;

Colours wall_colours(const Tints& tints, std::uint64_t district) {
    Colours out;
    for (std::uint64_t i = 1; i < 400; ++i) {
        const auto c = tints.of(Material::kWall, HouseNumber{i * 0x123456789, district});
        REQUIRE(c);
        out.insert({c->r, c->g, c->b});
    }
    return out;
}

const std::string kTenWalls =
    "[colours]\nwall = ['#000000', '#111111', '#222222', '#333333', '#444444', '#555555', "
    "'#666666', '#777777', '#888888', '#999999']\n";

std::string fingerprint(const Tints& tints) {
    voxel::ByteWriter out;
    tints.add_values(out);
    return voxel::to_hex(out.fingerprint());
}

}  // namespace

TEST_CASE("tints are chosen by longitude and latitude", "[voxelserver][voxelize][tints]") {
    struct Case {
        const char* name;
        geo::LatLon place;
        std::string wanted;
    };
    const auto c = GENERATE(values<Case>({
        {"Ljubljana", {46.05, 14.5}, "default"},
        {"Bled", {46.4, 14.1}, "default"},
        {"Koper", {45.55, 13.73}, "default"},
        {"Zurich", {47.4, 8.5}, "default"},
        {"Paris", {48.9, 2.3}, "default"},
        {"Munich", {48.1, 11.6}, "default"},
        {"Tokyo", {35.7, 139.7}, "default"},
        {"nowhere", {0, 0}, "default"},
        {"Delft", {52.0, 4.36}, "north"},
        {"Stockholm", {59.3, 18.1}, "north"},
        {"London", {51.5, -0.1}, "north"},
        {"Sevilla", {37.4, -6.0}, "mediterranean"},
        {"Montpellier", {43.6, 3.9}, "mediterranean"},
        {"Rome", {41.9, 12.5}, "mediterranean"},
        {"Athens", {38.0, 23.7}, "mediterranean"},
        {"Eugene", {44.05, -123.07}, "american_suburb"},
        {"Houston", {29.8, -95.4}, "american_suburb"},
    }));
    INFO(c.name);
    CHECK(choose_tints(kAnyTints, c.place).id() == c.wanted);
    CHECK(choose_tints("north", c.place).id() == "north");
}

TEST_CASE("every table of tints that ships has a title and another fingerprint",
          "[voxelserver][voxelize][tints]") {
    const std::vector<Tints> all = shipped_tints();
    REQUIRE(all.size() >= 4);
    std::set<std::string> fingerprints;
    for (const Tints& tints : all) {
        INFO(tints.id());
        CHECK_FALSE(tints.title().empty());
        CHECK(tints.regions().empty() == (tints.id() == "default"));
        CHECK(fingerprints.insert(fingerprint(tints)).second);
    }
    const std::string plain = fingerprint(tints_from(kTenWalls));
    CHECK(fingerprint(tints_from("district_share = 0.5\n" + kTenWalls)) != plain);
    CHECK(fingerprint(tints_from("wide = true\n" + kTenWalls)) != plain);
}

TEST_CASE("buildings of a district share few colours, by the share that keeps to it",
          "[voxelserver][voxelize][tints]") {
    CHECK(wall_colours(tints_from(kTenWalls), 7).size() == 10);
    const Tints all_keep = tints_from("district_share = 1\n" + kTenWalls);
    std::set<Colours> districts;
    for (const std::uint64_t district : {7, 8, 9, 10}) {
        const Colours found = wall_colours(all_keep, district);
        CHECK(found.size() <= 3);
        districts.insert(found);
    }
    CHECK(districts.size() > 1);
}

TEST_CASE("what is too wide to be known takes the first colour as it is",
          "[voxelserver][voxelize][tints]") {
    const Tints tints =
        tints_from("brightness = 0.5\nwide = true\n[colours]\nwall = ['#102030', '#ffffff']\n");
    CHECK(tints.has_wide());
    CHECK(tints.of(Material::kWall, HouseNumber{5, 5, true}) == voxel::Rgb8{0x10, 0x20, 0x30});
}

TEST_CASE("bad regions and shares are refused, naming what is wrong",
          "[voxelserver][voxelize][tints][bad]") {
    struct Case {
        const char* text;
        const char* part;
    };
    const auto c = GENERATE(values<Case>({
        {"district_share = 1.5\n[colours]\n", "district_share is 1.5; allowed: 0 to 1"},
        {"wide = 1\n[colours]\n", "wide is not true or false"},
        {"meant = 3\n[colours]\n", "meant is no table"},
        {"[colours]\n[meant]\ncrs = ['EPSG:3794']\n", "[meant] crs is no field"},
        {"[colours]\n[meant]\nregions = [7]\n", "regions holds 7"},
        {"[colours]\n[meant]\nregions = []\n", "no list of regions"},
        {"[colours]\n[meant]\nregions = [[1, 2, 3]]\n", "west, south, east, north"},
        {"[colours]\n[meant]\nregions = [[1, 2, 3, 'x']]\n", "holds another list"},
        {"[colours]\n[meant]\nregions = [[3, 2, 1, 4]]\n", "holds another list"},
        {"[colours]\n[meant]\nregions = [[3, 2, 4, 91]]\n", "holds another list"},
    }));
    INFO(c.text);
    CHECK_THROWS_AS(tints_from(c.text), util::UsageError);
    CHECK_THROWS_WITH(tints_from(c.text), contains("mine.toml") && contains(c.part));
}
