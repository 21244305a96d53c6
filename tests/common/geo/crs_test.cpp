#include "common/geo/crs.hpp"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <thread>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::geo;
using terravox::test::contains;

namespace {

constexpr double kFoot_m = 0.3048;
constexpr double kUsFoot_m = 1200.0 / 3937;
constexpr LatLon kLjubljanaCastle{46.0489, 14.5085};

// GeoTIFF's numbers (OGC 19-008r4) that the tests use.
enum Key : std::uint16_t {
    kModelType = 1024,
    kCitation = 1026,
    kGeographic = 2048,
    kAngularUnits = 2054,
    kProjected = 3072,
    kProjectedCitation = 3073,
    kProjection = 3074,
    kMethod = 3075,
    kLinearUnits = 3076,
    kOriginLon = 3080,
    kOriginLat = 3081,
    kFalseEasting = 3082,
    kFalseNorthing = 3083,
    kScale = 3092,
    kVertical = 4096,
    kVerticalUnits = 4099
};
constexpr std::uint16_t kUserDefined = 32767;
constexpr std::uint16_t kMetre = 9001;
constexpr std::uint16_t kInternationalFoot = 9002;
constexpr std::uint16_t kUsSurveyFoot = 9003;
constexpr std::uint16_t kTransverseMercator = 1;

// Builds the three tags as a LAS writer does.
struct GeoKeys {
    std::vector<std::uint16_t> directory = {1, 1, 0, 0};
    std::vector<double> doubles;
    std::string ascii;

    GeoKeys& code(Key key, std::uint16_t value) { return put(key, 0, 1, value); }
    GeoKeys& number(Key key, double value) {
        doubles.push_back(value);
        return put(key, 34736, 1, static_cast<std::uint16_t>(doubles.size() - 1));
    }
    GeoKeys& text(Key key, const std::string& value) {
        const auto at = static_cast<std::uint16_t>(ascii.size());
        ascii += value + "|";
        return put(key, 34737, static_cast<std::uint16_t>(value.size() + 1), at);
    }
    [[nodiscard]] std::optional<Crs> read() const {
        return Crs::from_geokeys(directory, doubles, ascii);
    }

private:
    GeoKeys& put(Key key, std::uint16_t where, std::uint16_t count, std::uint16_t value) {
        directory.insert(directory.end(), {static_cast<std::uint16_t>(key), where, count, value});
        ++directory[3];
        return *this;
    }
};

double metres_between(LatLon a, LatLon b) {
    constexpr double kRad = std::numbers::pi / 180;
    constexpr double kRadius_m = 6'371'000;
    return kRadius_m * kRad *
           std::hypot(a.lat_deg - b.lat_deg, (a.lon_deg - b.lon_deg) * std::cos(a.lat_deg * kRad));
}

}  // namespace

TEST_CASE("systems have their units and kind", "[common][geo][crs]") {
    struct Case {
        const char* text;
        bool geographic;
        bool pseudo_mercator;
        double metres_per_unit;
        std::optional<double> vertical;
    };
    const auto c = GENERATE(values<Case>({
        {"EPSG:3794", false, false, 1, {}},          // Slovenia
        {"EPSG:28992", false, false, 1, {}},         // Netherlands
        {"EPSG:2994", false, false, kFoot_m, {}},    // Oregon, international feet
        {"EPSG:2263", false, false, kUsFoot_m, {}},  // New York, US survey feet
        {"EPSG:3857", false, true, 1, {}},
        {"ESRI:102100", false, true, 1, {}},
        {"EPSG:4326", true, false, 1, {}},
        {"EPSG:4269", true, false, 1, {}},
        {"EPSG:7415", false, false, 1, 1.0},  // Netherlands with NAP heights
        {"EPSG:2994+6360", false, false, kFoot_m, kUsFoot_m},
        {"EPSG:2994+5703", false, false, kFoot_m, 1.0},
        {"EPSG:6557+8228", false, false, kFoot_m, kFoot_m},
        {"EPSG:26910+6360", false, false, 1, kUsFoot_m},
        {"EPSG:3857+5703", false, true, 1, 1.0},
        {"EPSG:4326+5703", true, false, 1, 1.0},
        {"+proj=tmerc +lat_0=0 +lon_0=15 +k=0.9999 +x_0=500000 +y_0=-5000000 +ellps=GRS80 +units=m",
         false,
         false,
         1,
         {}},
        {"+proj=utm +zone=33 +datum=WGS84 +units=us-ft", false, false, kUsFoot_m, {}},
    }));
    DYNAMIC_SECTION(c.text) {
        const Crs crs = Crs::from_text(c.text);
        CHECK(crs.geographic() == c.geographic);
        CHECK(crs.pseudo_mercator() == c.pseudo_mercator);
        CHECK(crs.metres_per_unit() == Approx(c.metres_per_unit).epsilon(1e-12));
        CHECK(crs.vertical_metres_per_unit().has_value() == c.vertical.has_value());
        if (c.vertical && crs.vertical_metres_per_unit())
            CHECK(*crs.vertical_metres_per_unit() == Approx(*c.vertical).epsilon(1e-9));
    }
}

TEST_CASE("a system is the same after a trip through WKT", "[common][geo][crs]") {
    const char* text = GENERATE("EPSG:3794", "EPSG:28992", "EPSG:2994", "EPSG:3857", "EPSG:4326",
                                "EPSG:7415", "EPSG:2994+6360");
    DYNAMIC_SECTION(text) {
        const Crs crs = Crs::from_text(text);
        const Crs back = Crs::from_text(crs.wkt());
        CHECK(crs.wkt().find('\n') == std::string::npos);
        CHECK(Crs::from_text(back.wkt()).wkt() == back.wkt());
        CHECK(back.name() == crs.name());
        CHECK(back.same_horizontal(crs));
        CHECK(back.metres_per_unit() == crs.metres_per_unit());
        CHECK(back.vertical_metres_per_unit() == crs.vertical_metres_per_unit());
        CHECK(back.pseudo_mercator() == crs.pseudo_mercator());
        CHECK(back.geographic() == crs.geographic());
    }
}

TEST_CASE("pseudo-Mercator is known without its code", "[common][geo][crs]") {
    // As files carry it whose writer left the authority out.
    const auto without_ids = [](std::string wkt) {
        for (auto at = wkt.find(",ID["); at != std::string::npos; at = wkt.find(",ID["))
            wkt.erase(at, wkt.find(']', at) + 1 - at);
        return wkt;
    };
    const auto c = GENERATE(values<std::pair<const char*, bool>>(
        {{"EPSG:3857", true}, {"EPSG:3395", false}, {"EPSG:3794", false}}));
    DYNAMIC_SECTION(c.first) {
        CHECK(Crs::from_text(without_ids(Crs::from_text(c.first).wkt())).pseudo_mercator() ==
              c.second);
    }
}

TEST_CASE("a code that belongs to another authority is not pseudo-Mercator's",
          "[common][geo][crs]") {
    CHECK(Crs::from_text("+proj=webmerc +datum=WGS84").pseudo_mercator());
    CHECK(Crs::from_text("+proj=merc +a=6378137 +b=6378137 +lat_ts=0 +lon_0=0 +x_0=0 +y_0=0 +k=1 "
                         "+units=m +nadgrids=@null +wktext")
              .pseudo_mercator());
    CHECK_FALSE(Crs::from_text("+proj=merc +datum=WGS84").pseudo_mercator());
}

TEST_CASE("systems are the same when their horizontal parts are", "[common][geo][crs]") {
    struct Case {
        const char* a;
        const char* b;
        bool same;
    };
    const auto c = GENERATE(values<Case>({
        {"EPSG:3794", "EPSG:3794", true},
        {"EPSG:28992", "EPSG:7415", true},
        {"EPSG:3794", "EPSG:3857", false},
        {"EPSG:2994", "EPSG:2993", false},
        {"EPSG:25832", "EPSG:25833", false},
        {"EPSG:4326", "EPSG:3857", false},
    }));
    DYNAMIC_SECTION(c.a << " and " << c.b) {
        CHECK(Crs::from_text(c.a).same_horizontal(Crs::from_text(c.b)) == c.same);
        CHECK(Crs::from_text(c.b).same_horizontal(Crs::from_text(c.a)) == c.same);
    }
}

TEST_CASE("text that is no system is refused by that text", "[common][geo][crs]") {
    const char* text =
        GENERATE("", "Ljubljana", "EPSG:", "EPSG:999999", "EPSG:abc", "+proj=nothing",
                 "PROJCS[\"half", "/etc/passwd", "http://127.0.0.1:1/crs.wkt", "{}", "\x01\xff");
    DYNAMIC_SECTION("'" << text << "'") {
        CHECK_THROWS_AS(Crs::from_text(text), util::UsageError);
        CHECK_THROWS_WITH(Crs::from_text(text), contains("'" + std::string(text) + "'") &&
                                                    contains("EPSG:<code>, WKT or a PROJ string"));
    }
}

TEST_CASE("GeoTIFF keys with a code give that system", "[common][geo][crs]") {
    const std::uint16_t code = GENERATE(as<std::uint16_t>(), 3794, 28992, 25832, 2994, 2263, 3857);
    INFO("EPSG:" << code);
    const auto crs = GeoKeys().code(kModelType, 1).code(kProjected, code).read();
    REQUIRE(crs);
    const Crs expected = Crs::from_text("EPSG:" + std::to_string(code));
    CHECK(crs->name() == expected.name());
    CHECK(crs->same_horizontal(expected));
    CHECK(crs->metres_per_unit() == Approx(expected.metres_per_unit()).epsilon(1e-12));
    CHECK(crs->pseudo_mercator() == expected.pseudo_mercator());
    CHECK_FALSE(crs->geographic());
}

TEST_CASE("GeoTIFF keys of a geographic system give degrees", "[common][geo][crs]") {
    const auto crs =
        GeoKeys().code(kModelType, 2).code(kGeographic, 4326).code(kAngularUnits, 9102).read();
    REQUIRE(crs);
    CHECK(crs->geographic());
    CHECK(crs->same_horizontal(Crs::from_text("EPSG:4326")));
}

TEST_CASE("GeoTIFF keys define the unit of heights: the stated one before the vertical system's",
          "[common][geo][crs]") {
    constexpr std::uint16_t kNone = 0;
    constexpr std::uint16_t kNavd88 = 5703;
    constexpr std::uint16_t kNavd88UsFeet = 6360;
    struct Case {
        const char* name;
        std::uint16_t projected;
        std::uint16_t vertical;
        std::uint16_t unit;
        std::optional<double> metres;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"nothing stated", 26910, kNone, kNone, {}},
        {"a system in metres", 26910, kNavd88, kNone, 1.0},
        {"a system in metres, said twice", 26910, kNavd88, kMetre, 1.0},
        {"a system in US feet", 26910, kNavd88UsFeet, kNone, kUsFoot_m},
        {"a system in metres, but feet stated", 26910, kNavd88, kUsSurveyFoot, kUsFoot_m},
        {"a unit alone: US feet over metres", 26910, kNone, kUsSurveyFoot, kUsFoot_m},
        {"a unit alone: international feet over metres", 26910, kNone, kInternationalFoot, kFoot_m},
        {"a unit alone: metres over feet", 2994, kNone, kMetre, 1.0},
        {"feet both ways, each its own", 2994, kNavd88, kUsSurveyFoot, kUsFoot_m},
        {"a unit alone that is rarer: Clarke's feet", 26910, kNone, 9005, 0.3047972654},
    }));
    DYNAMIC_SECTION(c.name) {
        GeoKeys keys = GeoKeys().code(kModelType, 1).code(kProjected, c.projected);
        if (c.vertical != kNone)
            keys.code(kVertical, c.vertical);
        if (c.unit != kNone)
            keys.code(kVerticalUnits, c.unit);
        const auto crs = keys.read();
        REQUIRE(crs);
        const Crs horizontal = Crs::from_text("EPSG:" + std::to_string(c.projected));
        CHECK(crs->same_horizontal(horizontal));
        CHECK(crs->metres_per_unit() == Approx(horizontal.metres_per_unit()).epsilon(1e-12));
        REQUIRE(crs->vertical_metres_per_unit().has_value() == c.metres.has_value());
        if (c.metres)
            CHECK(*crs->vertical_metres_per_unit() == Approx(*c.metres).epsilon(1e-9));
        // The unit also survives being written down.
        const Crs back = Crs::from_text(crs->wkt());
        REQUIRE(back.vertical_metres_per_unit().has_value() == c.metres.has_value());
        if (c.metres)
            CHECK(*back.vertical_metres_per_unit() == Approx(*c.metres).epsilon(1e-9));
        CHECK(back.same_horizontal(horizontal));
    }
}

TEST_CASE("GeoTIFF keys of a user-defined projection give that projection", "[common][geo][crs]") {
    const auto keys = [](std::uint16_t unit) {
        return GeoKeys()
            .code(kModelType, 1)
            .text(kCitation, "Slovenia by hand")
            .code(kGeographic, 4765)
            .code(kProjected, kUserDefined)
            .text(kProjectedCitation, "made by hand")
            .code(kProjection, kUserDefined)
            .code(kMethod, kTransverseMercator)
            .code(kLinearUnits, unit)
            .number(kOriginLon, 15)
            .number(kOriginLat, 0)
            .number(kFalseEasting, 500'000)
            .number(kFalseNorthing, -5'000'000)
            .number(kScale, 0.9999);
    };
    const auto crs = keys(kMetre).read();
    REQUIRE(crs);
    CHECK(crs->metres_per_unit() == 1);
    const LatLon mine = to_lat_lon(*crs, 461'971, 101'000);
    const LatLon official = to_lat_lon(Crs::from_text("EPSG:3794"), 461'971, 101'000);
    CHECK(metres_between(mine, official) < 0.001);
    const auto feet = keys(kUsSurveyFoot).read();
    REQUIRE(feet);
    CHECK(feet->metres_per_unit() == Approx(kUsFoot_m).epsilon(1e-9));
}

TEST_CASE("GeoTIFF keys that name no system give none", "[common][geo][crs]") {
    CHECK_FALSE(Crs::from_geokeys({}, {}, {}));
    CHECK_FALSE(GeoKeys().read());
    CHECK_FALSE(GeoKeys().code(kModelType, 1).read());
    CHECK_FALSE(GeoKeys().code(kModelType, 1).code(kLinearUnits, kMetre).read());
    CHECK_FALSE(GeoKeys().code(kModelType, kUserDefined).text(kCitation, "nothing").read());
}

TEST_CASE("GeoTIFF keys that state heights in a unit that is not known are refused",
          "[common][geo][crs]") {
    const auto keys = [](std::uint16_t unit) {
        return GeoKeys().code(kModelType, 1).code(kProjected, 3794).code(kVerticalUnits, unit);
    };
    constexpr std::uint16_t kOfNoKey = 9999;
    for (const std::uint16_t unit : {kOfNoKey, kUserDefined}) {
        INFO(unit);
        CHECK_THROWS_WITH(keys(unit).read(),
                          contains("unit of heights = " + std::to_string(unit)) &&
                              contains("9003 (US survey foot)"));
        const auto stated = geo::vertical_unit_of_keys(keys(unit).directory);
        CHECK(stated.code == unit);
        CHECK_FALSE(stated.metres);
    }
    CHECK(keys(0).read());
    CHECK(geo::vertical_unit_of_keys(keys(kUsSurveyFoot).directory).metres == kUsFoot_m);
}

TEST_CASE("the system of a file may stand in a .prj file beside it", "[common][geo][crs]") {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "a.jpg";
    CHECK_FALSE(Crs::from_side_file(file));
    struct Case {
        const char* name;
        std::string text;
        const char* crs;  ///< "": refused
    };
    for (const Case& c :
         {Case{"A.prj", "EPSG:3794", ""}, Case{"a.prj", "EPSG:3794\r\n", "EPSG:3794"},
          Case{"a.PRJ", Crs::from_text("EPSG:3794").wkt(), "EPSG:3794"},
          Case{"a.prj", "\xef\xbb\xbf" + Crs::from_text("EPSG:3794").wkt(), "EPSG:3794"},
          Case{"a.prj", "+proj=utm +zone=33", ""}, Case{"a.prj", "Projection TRANSVERSE", ""}}) {
        INFO(c.name << ": " << c.text);
        test::write_content(folder.path() / c.name, c.text);
        if (*c.crs != '\0')
            CHECK(Crs::from_side_file(file)->name() == c.crs);
        else if (std::string(c.name) == "a.prj")
            CHECK_THROWS_AS(Crs::from_side_file(file), util::Error);
        else
            CHECK_FALSE(Crs::from_side_file(file));
        std::filesystem::remove(folder.path() / c.name);
    }
}

TEST_CASE("random GeoTIFF keys do no harm", "[common][geo][crs]") {
    std::mt19937 random(21);
    for (int i = 0; i < 400; ++i) {
        GeoKeys keys = GeoKeys()
                           .code(kModelType, 1)
                           .code(kProjected, 3794)
                           .text(kCitation, "a name")
                           .number(kScale, 1);
        for (int flips = 1 + static_cast<int>(random() % 4); flips > 0; --flips)
            keys.directory[random() % keys.directory.size()] =
                static_cast<std::uint16_t>(random() % 3 == 0 ? random() : random() % 5000);
        if (random() % 4 == 0)
            keys.directory.resize(random() % keys.directory.size());
        if (random() % 4 == 0)
            keys.doubles.clear();
        if (random() % 4 == 0)
            keys.ascii.clear();
        INFO("try " << i);
        CHECK_NOTHROW((void)keys.read());
    }
}

TEST_CASE("places have their known coordinates", "[common][geo][crs]") {
    // Ljubljana castle; the Dutch reference point, the tower of Amersfoort (155000, 463000); the
    // origin of Web Mercator; Bern's old observatory (2600000, 1200000).
    struct Case {
        const char* name;
        const char* crs;
        double easting;
        double northing;
        LatLon place;
        double within_m;
    };
    const auto c = GENERATE(values<Case>({
        {"Ljubljana castle", "EPSG:3794", 461'970, 101'135, kLjubljanaCastle, 20},
        {"Amersfoort", "EPSG:28992", 155'000, 463'000, {52.155172, 5.387204}, 2},
        {"Bern", "EPSG:2056", 2'600'000, 1'200'000, {46.951083, 7.438632}, 2},
        {"Greenwich on the equator", "EPSG:3857", 0, 0, {0, 0}, 0.001},
        {"the corner of Web Mercator",
         "EPSG:3857",
         20'037'508.342789244,
         20'037'508.342789244,
         {85.0511287798066, 180},
         0.001},
    }));
    DYNAMIC_SECTION(c.name) {
        const LatLon place = to_lat_lon(Crs::from_text(c.crs), c.easting, c.northing);
        INFO(place.lat_deg << ", " << place.lon_deg);
        CHECK(metres_between(place, c.place) < c.within_m);
    }
}

TEST_CASE("a map's north has its known angle to true north", "[common][geo][crs]") {
    // PROJ's meridian convergence, read by pyproj 3.7's Proj.get_factors; of the polar system the
    // longitude itself.
    struct Case {
        const char* name;
        const char* crs;
        double easting;
        double northing;
        double convergence_deg;
    };
    const auto c = GENERATE(values<Case>({
        {"west of the meridian", "EPSG:3794", 461'970, 101'135, -0.3537974},
        {"the west of Slovenia", "EPSG:3794", 374'000, 35'000, -1.1478518},
        {"the east of Slovenia", "EPSG:3794", 620'000, 170'000, 1.1405115},
        {"on the meridian", "EPSG:28992", 155'000, 463'000, 0},
        {"Delft", "EPSG:28992", 85'000, 446'000, -0.8042066},
        {"the edge of a zone", "EPSG:32633", 820'000, 5'100'000, 2.9731792},
        {"the edge of a southern zone", "EPSG:32733", 180'000, 6'200'000, 1.9602547},
        {"a conic system", "EPSG:2154", 770'000, 6'279'000, 0.6289458},
        {"an oblique conic system", "EPSG:5514", -740'000, -1'040'000, -7.8069331},
        {"a system in feet", "EPSG:2263", 990'000, 200'000, 0.0135669},
        {"Web Mercator", "EPSG:3857", 1'500'000, 5'800'000, 0},
        {"beyond the polar circle", "EPSG:3995", 500'000, -500'000, 45},
    }));
    DYNAMIC_SECTION(c.name) {
        const Crs crs = Crs::from_text(c.crs);
        const MapPlace place = map_place(crs, c.easting, c.northing);
        // Datums are turned against each other by some arc-seconds.
        CHECK(std::abs(place.convergence_deg - c.convergence_deg) < 0.003);
        const LatLon same = to_lat_lon(crs, c.easting, c.northing);
        CHECK(std::abs(place.lat_deg - same.lat_deg) < 6e-9);
        CHECK(std::abs(place.lon_deg - same.lon_deg) < 6e-9);
    }
}

TEST_CASE("where a map is does not depend on the last digits of coordinates",
          "[common][geo][crs]") {
    // Versions of PROJ differ by less than a millionth of a metre.
    const Crs crs = Crs::from_text("EPSG:3794");
    const MapPlace place = map_place(crs, 462'000, 101'000);
    const MapPlace moved = map_place(crs, 462'000 + 1e-6, 101'000 + 1e-6);
    CHECK(place.lat_deg == moved.lat_deg);
    CHECK(place.lon_deg == moved.lon_deg);
    CHECK(place.convergence_deg == moved.convergence_deg);
    const MapPlace meridian = map_place(crs, 500'000, 101'000);
    CHECK(meridian.convergence_deg == 0);
    CHECK_FALSE(std::signbit(meridian.convergence_deg));
}

TEST_CASE("axes are easting and northing, longitude and latitude, for every system",
          "[common][geo][crs]") {
    // EPSG orders these northing first or latitude first.
    const char* text = GENERATE("EPSG:3794", "EPSG:31468", "EPSG:2180");
    DYNAMIC_SECTION(text) {
        const Transform there(Crs::from_text("EPSG:4326"), Crs::from_text(text));
        double x[2] = {14.5, 14.6}, y[2] = {48, 48};
        there.apply(x, y);
        CHECK(x[1] - x[0] > 7000);
        CHECK(std::abs(y[1] - y[0]) < 1000);
    }
}

TEST_CASE("a point outside the domain is an error wherever it stands in the list",
          "[common][geo][crs]") {
    const Transform transform(Crs::from_text("EPSG:4326"), Crs::from_text("EPSG:3794"));
    const std::size_t bad = GENERATE(std::size_t{0}, std::size_t{1}, std::size_t{2});
    INFO("bad point at " << bad);
    double x[3] = {14, 15, 16}, y[3] = {46, 46, 46};
    y[bad] = 1e9;
    CHECK_THROWS_AS(transform.apply(x, y), util::Error);
    double x2[3] = {14, 15, 16}, y2[3] = {46, 46, 46};
    x2[bad] = std::nan("");
    CHECK_THROWS_AS(transform.apply(x2, y2), util::Error);
}

TEST_CASE("lists of different length are an error, empty ones are none", "[common][geo][crs]") {
    const Transform transform(Crs::from_text("EPSG:4326"), Crs::from_text("EPSG:3794"));
    double x[2] = {14, 15}, y[1] = {46};
    CHECK_THROWS_WITH(transform.apply(x, y), contains("2 x but 1 y"));
    CHECK_NOTHROW(transform.apply({}, {}));
}

TEST_CASE("threads may share a system when each has its own transform", "[common][geo][crs]") {
    const Crs from = Crs::from_text("EPSG:3794");
    const Crs to = Crs::from_text("EPSG:4326");
    const LatLon expected = to_lat_lon(from, 461'971, 101'044);
    std::vector<int> wrong(4, -1);
    std::vector<std::thread> threads;
    for (int& mine : wrong)
        threads.emplace_back([&] {
            const Transform transform(from, to);
            mine = 0;
            for (int i = 0; i < 200; ++i) {
                double x = 461'971;
                double y = 101'044;
                transform.apply({&x, 1}, {&y, 1});
                mine += x != expected.lon_deg || y != expected.lat_deg;
                mine += GeoKeys().code(kModelType, 1).code(kProjected, 3794).read()->name() !=
                            "EPSG:3794" &&
                        i % 50 == 0;
            }
        });
    for (auto& thread : threads)
        thread.join();
    for (const int mine : wrong)
        CHECK(mine == 0);
}

TEST_CASE("a system names the reference of its heights", "[common][geo][crs]") {
    struct Case {
        const char *crs, *datum;
    };
    const auto c = GENERATE(values<Case>({
        {"EPSG:2154", ""},
        {"EPSG:4326", ""},
        {"EPSG:4979", "ellipsoid"},
        {"EPSG:2154+5720", "IGN69"},
        {"EPSG:6339+5703", "North American Vertical Datum 1988"},
        {"EPSG:6339+6360", "North American Vertical Datum 1988"},  // in feet
        {"EPSG:3794+8690", "Slovenian Vertical System 2010"},
    }));
    DYNAMIC_SECTION(c.crs) {
        const auto datum = Crs::from_text(c.crs).vertical_datum();
        CHECK(datum.has_value() == (*c.datum != '\0'));
        CHECK_THAT(datum.value_or(""), contains(c.datum));
    }
    // A file that says no more than the unit says nothing of the datum.
    const auto feet = GeoKeys()
                          .code(kModelType, 1)
                          .code(kProjected, 2154)
                          .code(kVerticalUnits, kInternationalFoot)
                          .read();
    REQUIRE(feet);
    CHECK(feet->vertical_metres_per_unit() == kFoot_m);
    CHECK_FALSE(feet->vertical_datum());
    for (const std::string name :
         {"Not specified (based on WGS 84 ellipsoid)", "unknown", "Unnamed"}) {
        INFO(name);
        CHECK_FALSE(
            Crs::from_text("COMPOUNDCRS[\"c\"," + Crs::from_text("EPSG:3794").wkt() +
                           ",VERTCRS[\"h\",VDATUM[\"" + name +
                           "\"],CS[vertical,1],AXIS[\"height\",up],LENGTHUNIT[\"metre\",1]]]")
                .vertical_datum());
    }
}

TEST_CASE("a system that says not where on the Earth it is, is none", "[common][geo][crs]") {
    const std::string site =
        "LOCAL_CS[\"Site grid\",LOCAL_DATUM[\"Site\",0],UNIT[\"metre\",1],AXIS[\"X\",EAST],"
        "AXIS[\"Y\",NORTH]]";
    for (const std::string& text : {site, std::string("EPSG:5703")}) {
        INFO(text);
        CHECK_THROWS_WITH(Crs::from_text(text), contains("does not say where on the Earth"));
    }
    CHECK_THROWS_WITH(Crs::from_text("EPSG:4978"), contains("begin at the Earth's centre"));
    CHECK_THROWS_WITH(Crs::from_wkt(site), contains("'Site grid'"));
    CHECK_FALSE(GeoKeys().code(kModelType, 1).code(kVerticalUnits, kInternationalFoot).read());
}
