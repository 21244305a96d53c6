#include <algorithm>
#include <array>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/voxelserver/serve/gkot/box_grid.hpp"
#include "voxelserver/serve/gkot/gkot_reply.hpp"
#include "voxelserver/serve/gkot/gkot_request.hpp"

using namespace terravox;
using terravox::test::replaced;
using test::BoxGrid;
using voxel::Material;

namespace {

gkot::BoxRequest make_request(double tmx, double tmy, double tmz, std::array<std::int32_t, 3> box,
                              std::array<std::int32_t, 3> sizes) {
    gkot::BoxRequest out;
    out.origin = {tmx, tmy};
    out.tmz = tmz;
    out.x = box[0];
    out.y = box[1];
    out.z = box[2];
    out.sx = sizes[0];
    out.sy = sizes[1];
    out.sz = sizes[2];
    return out;
}

}  // namespace

TEST_CASE("a reply holds the blocks of its region", "[gkot][reply]") {
    BoxGrid grid(3);
    // Origin (-10, 20) and northing 15: x = -10, z = -15; box (1, -1, 0) of 32 x 64 x 16.
    const auto request = make_request(-10, 15, 20, {1, -1, 0}, {32, 64, 16});
    const auto blocks =
        gkot::read_blocks(grid.info.bounds, {-10 + 32, 20 - 64, -15, 32, 64, 16}, grid.fetch());
    CHECK(std::ranges::any_of(blocks, [](std::uint32_t word) { return word != 0; }));
    CHECK(gkot::box_reply(grid.info, request, grid.fetch()) == gkot::encode_reply(request, blocks));
}

TEST_CASE("an empty box has -2 and is as long as others", "[gkot][reply]") {
    BoxGrid grid(3);
    const auto request = make_request(0, 0, 5000, {0, 0, 0}, {1, 1, 2});
    const std::string none(12, '\0');
    CHECK(gkot::box_reply(grid.info, request, grid.fetch()) ==
          none + "\xff\xff\xff\xfe" + std::string("\0\0\0\2\0\0\0\0\0\0\0\0\0\0\0\2", 16) +
              std::string(8, '\xff'));
}

TEST_CASE("bytes are big-endian in the order that the protocol names", "[gkot][reply]") {
    const auto request = make_request(0, 0, 0, {-1, 2, 258}, {2, 2, 1});
    const std::string reply = gkot::encode_reply(request, {0x823, 0, 0x112, 0});
    const std::string expected(
        "\xff\xff\xff\xff\0\0\0\2\0\0\1\2\0\0\0\1\0\0\0\4"
        "\0\0\x08\x23\0\0\0\0\0\0\x01\x12\0\0\0\0"
        "\0\0\0\2"
        "\0\0\0\1\xff\xff\xff\xff",
        48);
    CHECK(reply == expected);
}

TEST_CASE("origins count from voxels by floor, also below zero and with other voxels and units",
          "[gkot][reply]") {
    struct Case {
        const char* name;
        double units;
        double voxel_m;
        double tmx;
        double tmy;
        double tmz;
        std::int64_t x;
        std::int64_t y;
        std::int64_t z;
    };
    const auto c = GENERATE(values<Case>({
        {"whole metres", 1, 1, 462000, 101000, 300, 462000, 300, -101000},
        {"decimals are not cut", 1, 1, 462000.9, 101000.2, 300.9, 462000, 300, -101001},
        {"below zero by floor", 1, 1, -0.5, -0.5, -0.5, -1, -1, 0},
        {"half metre voxels", 0.5, 0.5, 10.3, 10.3, 10.3, 20, 20, -21},
        {"feet", 3.28083989501312, 1, 32.9, -32.9, 10, 10, 10, 10},
        {"far out", 1e-3, 1e-3, 1e9, -1e9, 1e6, 1000000000000, 1000000000, 1000000000000},
    }));
    DYNAMIC_SECTION(c.name) {
        voxel::WorldInfo info;
        info.crs_units_per_voxel = c.units;
        info.voxel_m = c.voxel_m;
        const auto region = gkot::find_region(
            info, make_request(c.tmx, c.tmy, c.tmz, {0, 0, 0}, {4, 4, 4}), nullptr);
        CHECK(region.x == c.x);
        CHECK(region.y == c.y);
        CHECK(region.z == c.z);
        const auto far = gkot::find_region(
            info, make_request(c.tmx, c.tmy, c.tmz, {INT32_MIN, INT32_MAX, -1}, {512, 512, 64}),
            nullptr);
        CHECK(far.x == c.x - (std::int64_t{512} << 31));
        CHECK(far.y == c.y + std::int64_t{INT32_MAX} * 512);
        CHECK(far.z == c.z - 64);
    }
}

TEST_CASE("blocks of the first system keep their numbers and data", "[gkot][blocks]") {
    struct Case {
        Material material;
        std::uint32_t word;
    };
    const auto c = GENERATE(values<Case>({
        {Material::kAir, 0x000},
        {Material::kGround, 0x003},
        {Material::kLowVegetation, 0x002},
        {Material::kMediumVegetation, 0x112},
        {Material::kHighVegetation, 0x012},
        {Material::kWall, 0x823},
        {Material::kRoof, 0x823},
        {Material::kGreyRoof, 0x823},
        {Material::kConcrete, 0x823},
        {Material::kOrangeRoof, 0x123},
        {Material::kFlatRoof, 0x023},
        {Material::kRoad, 0x001},
        {Material::kWater, 0x009},
    }));
    DYNAMIC_SECTION(voxel::material_name(c.material)) {
        CHECK(gkot::block_word(c.material) == c.word);
    }
}

TEST_CASE("every material but air is a block, within the bits that words have", "[gkot][blocks]") {
    for (int i = 1; i < 256; ++i) {
        INFO("material " << i);
        const std::uint32_t word = gkot::block_word(static_cast<Material>(i));
        CHECK((word & 0xff) != 0);
        CHECK(word <= 0xfff);
    }
    CHECK(gkot::block_word(Material::kUnknown) == 0x223);
    CHECK(gkot::block_word(static_cast<Material>(200)) == gkot::block_word(Material::kUnknown));
}

namespace {
const std::string kGood =
    "format=raw&tmx=462000&tmy=101000&tmz=300&x=1&y=0&z=-2&sx=64&sy=256&sz=64";
}  // namespace

TEST_CASE("a request of the first system is understood", "[gkot][request]") {
    const auto r = gkot::parse_box_request(kGood);
    CHECK(r.origin.tmx == 462000);
    CHECK(r.origin.tmy == 101000);
    CHECK(r.tmz == 300.0);
    CHECK(r.x == 1);
    CHECK(r.y == 0);
    CHECK(r.z == -2);
    CHECK(r.sx == 64);
    CHECK(r.sy == 256);
    CHECK(r.sz == 64);
    CHECK(gkot::parse_origin_request("tmy=-2.5&tmx=1e3").tmx == 1000);
}

TEST_CASE("what may be left out or added is", "[gkot][request]") {
    CHECK_FALSE(gkot::parse_box_request(replaced(kGood, "&tmz=300", "")).tmz.has_value());
    CHECK(gkot::parse_box_request("&&" + kGood + "&&nocache=5&nocache=6&flag&=7&").x == 1);
    CHECK(gkot::parse_box_request(replaced(kGood, "tmx=462000", "t%6Dx=%34%36%32000.75"))
              .origin.tmx == 462000.75);
    CHECK(gkot::parse_box_request(
              replaced(replaced(kGood, "x=1&", "x=-2147483648&"), "z=-2", "z=2147483647"))
              .z == INT32_MAX);
    CHECK(gkot::parse_origin_request("tmx=1&tmy=2&sx=many").tmy ==
          2);  // not a parameter of this one
    CHECK(gkot::parse_box_request(
              replaced(replaced(replaced(kGood, "sx=64", "sx=512"), "sy=256", "sy=64"), "sz=64",
                       "sz=512"))
              .sx == 512);
}

TEST_CASE("requests that cannot be are refused by name, value and range", "[gkot][request]") {
    struct Case {
        const char *name, *part, *replacement, *message;
    };
    const auto c = GENERATE(values<Case>({
        {"no format", "format=raw&", "", "format is missing; allowed: raw"},
        {"amf", "format=raw", "format=amf", "format = 'amf'; allowed: raw"},
        {"missing", "&sz=64", "", "sz is missing; allowed: a power of two, 1 to 512"},
        {"twice", "x=1", "x=1&x=1", "x is given twice, '1' at first"},
        {"twice by encoding", "x=1", "x=1&%78=1", "x is given twice"},
        {"no equals sign", "x=1", "x", "x has no value"},
        {"nothing", "x=1", "x=", "x = ''; allowed: a whole number from -2147483648 to 2147483647"},
        {"no integer", "x=1", "x=1.0", "x = '1.0'"},
        {"too large", "x=1", "x=2147483648", "x = '2147483648'"},
        {"plus is a space", "x=1", "x=+1", "x = ' 1'"},
        {"space", "x=1", "x=1%20", "x = '1 '"},
        {"zero byte", "x=1", "x=1%00", "badly encoded"},
        {"cut encoding", "sz=64", "sz=64%4", "badly encoded"},
        {"no hexadecimal", "x=1", "x=%+1", "badly encoded"},
        {"nan", "tmx=462000", "tmx=nan",
         "tmx = 'nan'; allowed: a number from -1000000000 to 1000000000"},
        {"infinity", "tmx=462000", "tmx=inf", "tmx = 'inf'"},
        {"1e999", "tmy=101000", "tmy=1e999", "tmy = '1e999'"},
        {"-1e999", "tmz=300", "tmz=-1e999",
         "tmz = '-1e999'; allowed: a number from -1000000 to 1000000"},
        {"too far", "tmx=462000", "tmx=1000000001", "tmx = '1000000001'"},
        {"hexadecimal", "tmx=462000", "tmx=0x10", "tmx = '0x10'"},
        {"two numbers", "tmx=462000", "tmx=1,5", "tmx = '1,5'"},
        {"empty height", "tmz=300", "tmz=", "tmz = ''"},
        {"size 0", "sx=64", "sx=0", "sx = 0; allowed: a power of two, 1 to 512"},
        {"size 3", "sx=64", "sx=3", "sx = 3"},
        {"size 1024", "sy=256", "sy=1024", "sy = 1024"},
        {"size below 0", "sy=256", "sy=-2147483648", "sy = -2147483648"},
        {"volume", "sx=64&sy=256&sz=64", "sx=512&sy=512&sz=128",
         "sx * sy * sz = 33554432; allowed: 1 to 16777216"},
        {"line break", "x=1", "x=%0d%0aEvil:%201'", "x = '\\x0d\\x0aEvil: 1\\x27'"},
        {"long", "x=1", "x=1111111111111111111111111111111111111111111111111",
         "x = '1111111111111111111111111111111111111111...'"},
    }));
    DYNAMIC_SECTION(c.name) {
        const std::string query = replaced(kGood, c.part, c.replacement);
        CHECK_THROWS_AS(gkot::parse_box_request(query), util::UsageError);
        CHECK_THROWS_WITH(gkot::parse_box_request(query),
                          test::contains("send a box: ") && test::contains(c.message));
    }
}

TEST_CASE("a query without end is refused before it is read", "[gkot][request]") {
    CHECK_THROWS_WITH(gkot::parse_box_request(kGood + std::string(3000, '&')),
                      test::contains("allowed: 0 to 2048"));
    CHECK_THROWS_AS(gkot::parse_origin_request(""), util::UsageError);
}
