#include "voxelserver/serve/http/routes.hpp"

#include "tests/catch.hpp"

using namespace terravox;
using http::Route;

TEST_CASE("each path of the table is matched by its own route", "[voxelserver][http][routes]") {
    for (const http::RouteFacts& route : http::routes()) {
        INFO(route.path);
        const http::RouteMatch match = http::match_route(route.path);
        const bool is_path = route.path.front() == '/';
        CHECK(match.facts.route == (is_path ? route.route : Route::kUnknown));
        CHECK((match.parts.count > 0) == is_path);
    }
}

TEST_CASE("a path has the route whose parts it has, and views of these parts",
          "[voxelserver][http][routes]") {
    const http::RouteMatch match = http::match_route("/v2/boxes/0/-1/2/x");
    CHECK(match.facts.route == Route::kBox);
    REQUIRE(match.parts.count == 6);
    CHECK(match.parts.part[2] == "0");
    CHECK(match.parts.part[3] == "-1");
    CHECK(match.parts.part[5] == "x");
    CHECK(http::match_route("/map/1/2/3.png").facts.route == Route::kMapTile);
}

TEST_CASE("a path without a route is unknown", "[voxelserver][http][routes]") {
    const std::string path = GENERATE(
        "", "*", "v2/world", "/v2/world/", "//v2/world", "/v2//world", "/V2/world", "/v2",
        "/v1/world", "/v2/../v2/world", "/%2e%2e/world", "/v2/boxes/0/0/0", "/v2/boxes/0/0/0/0/",
        "/v2/columns/0/0", "/map/1/2/3.jpg", "/1/2/3/4/5/6/7", "/index.html");
    INFO(path);
    CHECK(http::match_route(path).facts.route == Route::kUnknown);
}
