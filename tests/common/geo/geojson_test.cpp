#include "common/geo/geojson.hpp"

#include <cmath>
#include <fstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

namespace {

using namespace terravox;
using test::contains;
using test::TemporaryFolder;

std::vector<geo::Shape> read(const std::string& text, const char* crs = "EPSG:3794") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.geojson";
    std::ofstream(file) << text;
    return geo::read_geojson(file, geo::Crs::from_text(crs));
}

std::string feature(const std::string& geometry, const std::string& properties = "null") {
    return R"({"type":"Feature","properties":)" + properties + R"(,"geometry":)" + geometry + "}";
}

}  // namespace

TEST_CASE("lengths are numbers of metres, or have a unit", "[common][geo]") {
    const auto height = [](const std::string& value) {
        return read(feature(R"({"type":"Point","coordinates":[1,2]})",
                            R"({"height":)" + value + "}"))
            .at(0)
            .metres("height");
    };
    struct Case {
        const char* text;
        double metres;
    };
    for (const Case& c :
         {Case{"7.5", 7.5}, Case{R"("7.5")", 7.5}, Case{R"("7.5 m")", 7.5},
          Case{R"(" +7.5m ")", 7.5}, Case{R"("750 cm")", 7.5}, Case{R"("30 ft")", 9.144},
          Case{R"("30'")", 9.144}, Case{R"("5'6\"")", 1.6764}, Case{R"("5' 6''")", 1.6764}}) {
        INFO(c.text);
        CHECK(std::abs(height(c.text) - c.metres) < 1e-9);
    }
    for (const char* text : {R"("m")", R"("nan")", R"("inf")", R"("1e999")", R"("7.5 m high")",
                             R"("7,5")", R"("5'6")", "true"}) {
        INFO(text);
        CHECK_THROWS_WITH(height(text), contains("a.geojson: feature 0 has height = "));
    }
    for (const char* text : {R"("")", "null"}) {
        INFO(text);
        CHECK(std::isnan(height(text)));
    }
}

TEST_CASE("geometries without positions are left out, those of a collection are one each",
          "[common][geo]") {
    const auto shapes =
        read(R"({"type":"FeatureCollection","features":[)" +
             feature(R"({"type":"Polygon","coordinates":[]})") + "," +
             feature(R"({"type":"GeometryCollection","geometries":[)"
                     R"({"type":"Point","coordinates":[15,46]},{"type":"Point","coordinates":[]},)"
                     R"({"type":"LineString","coordinates":[[15,46],[16,46]]}]})",
                     R"({"height":3})") +
             "]}");
    REQUIRE(shapes.size() == 2);
    CHECK(shapes[0].kind == geo::ShapeKind::kPoint);
    CHECK(shapes[1].kind == geo::ShapeKind::kLine);
    CHECK(shapes[1].feature == 1);
    CHECK(shapes[1].metres("height") == 3);
}

TEST_CASE("a feature without meaning is left out of a collection", "[common][geo]") {
    const std::string good = feature(R"({"type":"Point","coordinates":[15,46]})");
    for (const std::string& bad :
         {feature(R"({"type":"Curve","coordinates":[[1,2]]})"),
          feature(R"({"type":"Point","coordinates":[1,"2"]})"),
          feature(R"({"type":"Polygon","coordinates":[[]]})"), feature(R"({"type":"Point"})"),
          feature(R"({"type":"MultiPoint","coordinates":[[15,46],[1]]})"), std::string("7"),
          std::string(R"({"type":"Point","coordinates":[15,46]})"),
          feature(R"({"type":"Point","coordinates":[15,1e9]})")}) {
        INFO(bad);
        const std::string all = R"({"type":"FeatureCollection","features":[)";
        const auto shapes = read(all + good + "," + bad + "," + good + "]}");
        REQUIRE(shapes.size() == 2);
        CHECK(shapes[0].feature == 0);
        CHECK(shapes[1].feature == 2);
        CHECK(std::abs(shapes[1].parts[0][0][0] - 500'000) < 0.01);
        CHECK_THROWS_WITH(read(all + bad + "]}"), contains("feature 0"));
    }
}

TEST_CASE("a system may be named as an address", "[common][geo]") {
    const auto position = [](const std::string& name) {
        return read(R"({"type":"Point","coordinates":[462000,101000],)"
                    R"("crs":{"properties":{"name":")" +
                    name + R"("}}})")
            .at(0)
            .parts.at(0)
            .at(0);
    };
    for (const char* name :
         {"EPSG:3794", "urn:ogc:def:crs:EPSG::3794", "http://www.opengis.net/def/crs/EPSG/0/3794",
          "https://www.opengis.net/def/crs/EPSG/0/3794"}) {
        INFO(name);
        CHECK(position(name)[0] == 462000);
    }
    CHECK_THROWS_WITH(position("http://www.opengis.net/def/crs/EPSG/0/0"),
                      contains("a.geojson") && contains("EPSG:0"));
}

TEST_CASE("shapes of a GeoJSON file are read with their numbers", "[common][geo]") {
    const auto shapes = read(
        R"({"type":"FeatureCollection","crs":{"type":"name","properties":)"
        R"({"name":"urn:ogc:def:crs:EPSG::3794"}},"features":[)" +
        feature(R"({"type":"Point","coordinates":[462000,101000,12.5]})", R"({"id":"a"})") + "," +
        feature(R"({"type":"MultiPolygon","coordinates":[[[[0,0],[4,0],[4,4],[0,0]],)"
                R"([[1,1],[2,1],[2,2],[1,1]]],[[[9,9],[10,9],[10,10],[9,9]]]]})",
                R"({"height":30,"name":"tower"})") +
        "," + feature("null") + "," +
        feature(R"({"type":"LineString","coordinates":[[1,2],[3,4]]})") + "]}");
    REQUIRE(shapes.size() == 4);
    CHECK(shapes[0].kind == geo::ShapeKind::kPoint);
    CHECK(shapes[0].parts.at(0).at(0) == geo::Shape::Position{462000, 101000, 12.5});
    CHECK(std::isnan(shapes[0].metres("height")));
    CHECK(shapes[1].parts.size() == 2);
    CHECK(shapes[1].metres("height") == 30);
    CHECK(shapes[2].feature == 1);
    CHECK(shapes[3].kind == geo::ShapeKind::kLine);
    CHECK(shapes[3].feature == 3);
    CHECK(std::isnan(shapes[3].parts[0][0][2]));
}

TEST_CASE("features may stand on a line each, with or without separators", "[common][geo]") {
    const std::string one = feature(R"({"type":"Point","coordinates":[14.5,46.0]})");
    for (const std::string& text :
         {one + "\n" + one + "\n", one + "\r\n\r\n" + one, "\x1e" + one + "\n\x1e" + one + "\n"}) {
        INFO(text);
        const auto shapes = read(text, "OGC:CRS84");
        REQUIRE(shapes.size() == 2);
        CHECK(shapes[1].feature == 1);
        CHECK(shapes[1].parts[0][0][0] == 14.5);
    }
}

TEST_CASE("a GeoJSON file without a CRS is in longitude and latitude", "[common][geo]") {
    const auto shapes = read(R"({"type":"Point","coordinates":[15,46]})");
    // The middle meridian of the grid is 15 degrees east.
    CHECK(std::abs(shapes.at(0).parts[0][0][0] - 500'000) < 0.01);
    CHECK(std::abs(shapes.at(0).parts[0][0][1] - 94'000) < 3000);
}

TEST_CASE("a GeoJSON file of many brackets is refused", "[common][geo]") {
    const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
    for (const std::string& text :
         {R"({"type":"Point","coordinates":)" + deep + "}",
          R"({"type":"MultiPolygon","coordinates":)" + deep + "}",
          feature(R"({"type":"Point","coordinates":[15,46]})", R"({"height":)" + deep + "}"),
          std::string(200'000, '[')}) {
        INFO(text.substr(0, 60));
        CHECK_THROWS_WITH(read(text), contains("lists in lists"));
    }
}

TEST_CASE("a GeoJSON file of a million objects is read in one go", "[common][geo]") {
    // A parser that looks through all objects before it at the end of each takes an hour for this.
    std::string objects = "{}";
    for (int i = 0; i < 1'000'000; ++i)
        objects += ",{}";
    const auto shapes = read(feature(R"({"type":"Point","coordinates":[15,46]})",
                                     R"({"objects":[)" + objects + R"(],"height":3})"));
    CHECK(shapes.at(0).metres("height") == 3);
}

TEST_CASE("what is no GeoJSON is refused", "[common][geo]") {
    struct Case {
        const char* text;
        const char* says;
    };
    for (const Case& c : {
             Case{"", "no JSON from byte 1 on"},
             Case{R"({"type":"Topology","arcs":[]})", "feature 0 is a Topology; allowed: points"},
             Case{"{\"type\":\"Feature\",\"geometry\":null}\n{",
                  "line 2 of those with a feature each"},
             Case{"[1]", "no JSON object"},
             Case{"{}", "without a type"},
             Case{R"({"type":"Point"})", "coordinates"},
             Case{R"({"type":"Point","coordinates":[1]})", "no list of numbers"},
             Case{R"({"type":"Point","coordinates":[1,"2"]})", "no list of numbers"},
             Case{R"({"type":"Polygon","coordinates":[[]]})", "no positions"},
             Case{R"({"type":"Curve","coordinates":[[1,2]]})", "allowed: points"},
             Case{R"({"type":"FeatureCollection","features":[{"type":"Point"}]})", "is a Point"},
             Case{R"({"type":"Point","coordinates":[1,2],"crs":{}})", "without a name"},
             Case{R"({"type":"Point","coordinates":[1,2],"crs":[]})", "without a name"},
             Case{R"({"type":"Point","coordinates":[1,2],"crs":{"properties":[1]}})",
                  "without a name"},
             Case{R"({"type":"Point","coordinates":[1,2],)"
                  R"("crs":{"properties":{"name":"urn:ogc:def:crs:EPSG"}}})",
                  "allowed: urn:ogc:def:crs:AUTHORITY:VERSION:CODE"},
         }) {
        INFO(c.text);
        CHECK_THROWS_WITH(read(c.text), contains(c.says));
    }
    CHECK_THROWS_AS(geo::read_geojson("/nowhere.geojson", geo::Crs::from_text("EPSG:3794")),
                    util::Error);
    std::string many = R"({"type":"LineString","coordinates":[[1,2])";
    for (std::size_t i = 0; i < geo::kMaxGeoJsonPositions; ++i)
        many += ",[1,2]";
    CHECK_THROWS_WITH(read(many + "]}"), contains("more than 100000 positions"));
}

TEST_CASE("a reader of GeoJSON that is stopped ends with an error that names the file",
          "[common][geo][geojson]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "plan.geojson";
    std::ofstream(file) << R"({"type":"Point","coordinates":[14.5,46]})";
    const auto crs = geo::Crs::from_text("EPSG:3794");
    std::stop_source stop;
    CHECK(geo::read_geojson(file, crs, stop.get_token()).size() == 1);
    stop.request_stop();
    CHECK_THROWS_WITH(geo::read_geojson(file, crs, stop.get_token()),
                      contains("plan.geojson: interrupted"));
}
