#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "voxelserver/serve/gkot/gkot_request.hpp"

using namespace terravox;

namespace {
const std::string kGood =
    "format=raw&tmx=462000&tmy=101000&tmz=300&x=1&y=0&z=-2&sx=64&sy=256&sz=64";

std::string with(std::string from, const std::string& part, const std::string& replacement) {
    const auto at = from.find(part);
    REQUIRE(at != std::string::npos);
    return from.replace(at, part.size(), replacement);
}
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
    CHECK_FALSE(gkot::parse_box_request(with(kGood, "&tmz=300", "")).tmz.has_value());
    CHECK(gkot::parse_box_request("&&" + kGood + "&&nocache=5&nocache=6&flag&=7&").x == 1);
    CHECK(gkot::parse_box_request(with(kGood, "tmx=462000", "t%6Dx=%34%36%32000.75")).origin.tmx ==
          462000.75);
    CHECK(
        gkot::parse_box_request(with(with(kGood, "x=1&", "x=-2147483648&"), "z=-2", "z=2147483647"))
            .z == INT32_MAX);
    CHECK(gkot::parse_origin_request("tmx=1&tmy=2&sx=many").tmy ==
          2);  // not a parameter of this one
    CHECK(gkot::parse_box_request(
              with(with(with(kGood, "sx=64", "sx=512"), "sy=256", "sy=64"), "sz=64", "sz=512"))
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
        const std::string query = with(kGood, c.part, c.replacement);
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

TEST_CASE("damaged queries are understood or refused, never worse", "[gkot][request]") {
    std::mt19937_64 random(11);
    int understood = 0;
    for (int i = 0; i < 20000; ++i) {
        std::string query = kGood;
        for (int n = 0; n < 3; ++n)
            query[random() % query.size()] = "&=%+0123456789-.eEx\0\xff"[random() % 22];
        INFO("query " << query);
        try {
            const auto r = gkot::parse_box_request(query);
            REQUIRE(std::int64_t{r.sx} * r.sy * r.sz <= gkot::kMaxVoxels);
            ++understood;
        } catch (const util::UsageError& e) {
            REQUIRE(std::string(e.what()).find('\n') == std::string::npos);
        }
    }
    CHECK(understood > 0);
}
