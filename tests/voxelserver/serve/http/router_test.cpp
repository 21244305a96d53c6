#include "voxelserver/serve/http/router.hpp"

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "common/voxel/box.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"
#include "voxelserver/serve/http/routes.hpp"

using namespace terravox;
using http::Header;
using http::Request;
using http::Response;
using http::Route;

namespace {

struct RouterFixture {
    test::FakeWorld world;
    util::StageTimes times;
    boxes::BoxCache boxes{world, times, {.ahead = false}};
    http::Router router{http::Service{world, times, boxes}};

    Response get(std::string_view path, std::vector<Header> headers = {}) {
        return router.handle(Request{"GET", path, std::move(headers)});
    }
    Response send(std::string_view method, std::string_view path,
                  std::vector<Header> headers = {}) {
        return router.handle(Request{method, path, std::move(headers)});
    }
};

nlohmann::json to_json(const Response& r) {
    return nlohmann::json::parse(r.body ? *r.body : "");
}

}  // namespace

TEST_CASE("every path has its status", "[voxelserver][http][router]") {
    struct Case {
        int status;
        const char* paths;
    };
    const auto c = GENERATE(values<Case>({
        {200,
         "/healthz /v2/world /v2/stats /v2/boxes/0/0/0/0 /v2/boxes/0/1/-1/-1 "
         "/v2/boxes/2/0/-1/0 /v2/columns/0/0/0 /v2/columns/0/99/0"},
        {204, "/v2/boxes/0/0/1/0 /v2/boxes/0/2147483647/-2147483648/0"},
        {404,
         "/v2/boxes/3/0/0/0 /v2/boxes/-1/0/0/0 /v2/boxes/2147483647/0/0/0 /v2/columns/3/0/0 "
         "/../etc/passwd /nothing"},
        {400,
         "/v2/boxes/0/2147483648/0/0 /v2/boxes/0/-2147483649/0/0 /v2/boxes/0/x/0/0 "
         "/v2/boxes/0/99999999999999999999/0/0 /v2/boxes/0/1x/0/0 /v2/boxes/0/+1/0/0 "
         "/v2/boxes/0/-0/0/0 /v2/boxes/0/007/0/0 /v2/boxes/0/1.0/0/0 /v2/boxes/0/1e1/0/0 "
         "/v2/boxes/0/0x1/0/0 /v2/boxes/0/-/0/0 /v2/boxes/0//0/0 /v2/boxes/0/%31/0/0 "
         "/v2/boxes/0/0/0/ /v2/columns/0/a/0"},
    }));
    RouterFixture f;
    std::istringstream paths(c.paths);
    for (std::string path; paths >> path;) {
        INFO(path);
        const Response r = f.get(path);
        CHECK(r.status == c.status);
        CHECK_FALSE(r.close);
        if (c.status >= 400) {
            CHECK(r.header("Content-Type") == "application/problem+json");
            CHECK(to_json(r)["status"] == c.status);
        }
    }
    CHECK(f.get("/v2/boxes/0/ 1/0/0").status == 400);
}

TEST_CASE("HEAD is answered like GET", "[voxelserver][http][router]") {
    const std::string path = GENERATE("/healthz", "/v2/world", "/v2/boxes/0/0/0/0",
                                      "/v2/boxes/0/0/1/0", "/v2/columns/0/0/0", "/nothing");
    RouterFixture f;
    const Response head = f.send("HEAD", path);
    const Response get = f.get(path);
    CHECK(head.status == get.status);
    CHECK(head.bytes().size() == get.bytes().size());
    CHECK(head.header("ETag") == get.header("ETag"));
}

TEST_CASE("an entity tag that is still right is answered 304 without a body",
          "[voxelserver][http][router]") {
    const std::string path =
        GENERATE("/v2/world", "/v2/boxes/0/0/0/0", "/v2/boxes/0/0/1/0", "/v2/boxes/0/1000/0/0");
    RouterFixture f;
    const Response first = f.get(path);
    const std::string etag = first.header("ETag");
    const Response again = f.get(path, {{"if-none-match", "\"other\", " + etag}});
    CHECK(again.status == 304);
    CHECK_FALSE(again.body);
    CHECK(again.header("ETag") == etag);
    CHECK(f.get(path, {{"If-None-Match", "\"other\""}}).status == first.status);
}

TEST_CASE("a box is sent as a zstd frame to clients that accept it, and uncompressed to others",
          "[voxelserver][http][router]") {
    RouterFixture f;
    const Response packed = f.get("/v2/boxes/0/1/-1/-1", {{"Accept-Encoding", "gzip, zstd"}});
    const Response plain = f.get("/v2/boxes/0/1/-1/-1");
    for (const Response* r : {&packed, &plain}) {
        CHECK(r->header("Content-Type") == voxel::kBoxMediaType);
        CHECK(r->header("Vary") == "Accept-Encoding");
    }
    CHECK(packed.header("Content-Encoding") == "zstd");
    CHECK(plain.header("Content-Encoding").empty());
    CHECK(packed.header("ETag") != plain.header("ETag"));
    const auto box = voxel::decompress_box(std::as_bytes(std::span(*packed.body)), "the reply");
    CHECK(box->key() == voxel::BoxKey{0, 1, -1, -1});
    const bool same = std::string_view(reinterpret_cast<const char*>(box->blob().data()),
                                       box->blob().size()) == *plain.body;
    CHECK(same);
    CHECK(f.get("/v2/boxes/0/1/-1/-1", {{"Accept-Encoding", "identity;q=0"}}).status == 406);
    const Response air = f.get("/v2/boxes/0/0/1/0");
    CHECK_FALSE(air.body);
    CHECK(air.header("Content-Type").empty());
}

TEST_CASE("a box that cannot be made is a problem that says why, not air",
          "[voxelserver][http][router]") {
    RouterFixture f;
    f.world.failing.insert({0, 0, 0, 0});
    const Response r = f.get("/v2/boxes/0/0/0/0");
    CHECK(r.status == 500);
    CHECK(r.header("Content-Type") == "application/problem+json");
    CHECK_THAT(to_json(r)["detail"].get<std::string>(),
               test::contains("decode the square 'a\"b': damaged"));
    CHECK(r.header("ETag").empty());
    CHECK(f.get("/v2/boxes/0/1/0/0").status == 200);
    f.world.columns_fail = true;
    CHECK(f.get("/v2/columns/0/0/0").status == 500);
}

TEST_CASE("a column lists its boxes, and heights in voxels of level 0 within the world",
          "[voxelserver][http][router]") {
    RouterFixture f;
    CHECK(to_json(f.get("/v2/columns/0/0/0")) ==
          nlohmann::json{{"by_begin", -1}, {"by_end", 2}, {"min_y", -256}, {"max_y", 512}});
    CHECK(to_json(f.get("/v2/columns/2/0/0")) ==
          nlohmann::json{{"by_begin", -1}, {"by_end", 1}, {"min_y", -256}, {"max_y", 512}});
    CHECK(to_json(f.get("/v2/columns/0/-7/0")) ==
          nlohmann::json{{"by_begin", 0}, {"by_end", 0}, {"min_y", 0}, {"max_y", 0}});
}

TEST_CASE("statistics count requests by route and status", "[voxelserver][http][router]") {
    RouterFixture f;
    (void)f.get("/v2/boxes/0/0/0/0");
    (void)f.get("/v2/boxes/0/0/0/0");
    (void)f.get("/v2/boxes/0/0/1/0");
    (void)f.get("/nothing");
    const auto json = to_json(f.get("/v2/stats"));
    CHECK(json["requests"]["/v2/boxes/{level}/{bx}/{by}/{bz}"]["200"] == 2);
    CHECK(json["requests"]["/v2/boxes/{level}/{bx}/{by}/{bz}"]["204"] == 1);
    CHECK(json["requests"]["unknown"]["404"] == 1);
    CHECK(json["cache"]["hits"] == 1);
    CHECK(json["cache"]["misses"] == 2);
    CHECK(json["stages"].at(0)["name"] == "compression");
}

TEST_CASE("the reason of a failure is for clients with the token", "[voxelserver][http][router]") {
    RouterFixture f;
    http::Service service{f.world, f.times, f.boxes};
    service.health = [] { return http::Health{http::Health::State::kFailed, "cut short"}; };
    http::Router closed(service, "s3cret");
    const auto detail = [&](const char* token) {
        return to_json(
            closed.handle(Request{"GET", "/healthz", {{"Authorization", token}}}))["detail"];
    };
    CHECK(detail("Bearer s3cret") == "failed: cut short");
    CHECK(detail("Bearer wrong") ==
          "failed: only kept boxes can be served; the server's log says why");
}

TEST_CASE("the page may load its own files alone, and be shown in no other page",
          "[voxelserver][http][router]") {
    RouterFixture f;
    for (const char* path :
         {"/", "/page/app.js", "/page/app.css", "/view/", "/view/viewer/viewer.js",
          "/view/viewer/worker.js", "/view/viewer/viewer.css", "/view/viewer/licences.txt"}) {
        INFO(path);
        const Response r = f.get(path);
        REQUIRE(r.status == 200);
        const std::string policy = r.header("Content-Security-Policy");
        for (const char* part : {"default-src 'none'", "script-src 'self'", "style-src 'self'",
                                 "frame-ancestors 'none'", "base-uri 'none'"})
            CHECK_THAT(policy, test::contains(part));
        CHECK(policy.find("unsafe") == std::string::npos);
        CHECK(r.header("Referrer-Policy") == "no-referrer");
        CHECK(r.header("Cross-Origin-Opener-Policy") == "same-origin");
    }
}

TEST_CASE("the viewer is at /view/, where its relative addresses lead to its files",
          "[voxelserver][http][router]") {
    RouterFixture f;
    const Response from = f.get("/view");
    CHECK(from.status == 308);
    CHECK(from.header("Location") == "view/");
    CHECK(f.get("/view/").bytes().find("src=\"viewer/viewer.js\"") != std::string_view::npos);
    const Response place = f.get("/view/place.json");
    CHECK(place.header("Cache-Control") == "no-store");
    CHECK(to_json(place)["archive"]["server"] == "../");
    const Response appearance = f.get("/view/appearance.bin");
    CHECK(appearance.bytes().substr(0, 2) == "\x1f\x8b");
    CHECK(appearance.header("ETag") != "");
    for (const char* path : {"/view/viewer.js", "/view/viewer/app.js", "/view/viewer/viewer.html",
                             "/view/viewer/", "/view/place.tvx", "/view//"}) {
        INFO(path);
        CHECK(f.get(path).status == 404);
    }
}

TEST_CASE("metrics are in the text format of Prometheus, each family once",
          "[voxelserver][http][router]") {
    RouterFixture f;
    (void)f.get("/v2/boxes/0/0/0/0");
    const Response r = f.get("/metrics");
    CHECK(r.header("Content-Type") == "text/plain; version=0.0.4; charset=utf-8");
    std::istringstream lines(*r.body);
    std::set<std::string> families;
    std::string line;
    std::string family;
    while (std::getline(lines, line)) {
        INFO(line);
        std::istringstream words(line);
        std::string hash;
        std::string what;
        std::string name;
        if (line.front() == '#') {
            words >> hash >> what >> name;
            if (what == "HELP")
                CHECK(families.insert(name).second);
            family = name;
            continue;
        }
        CHECK(line.substr(0, family.size()) == family);
        CHECK_NOTHROW(std::stod(line.substr(line.rfind(' '))));
    }
    CHECK(r.body->find("terravox_boxes_made_total 1\n") != std::string::npos);
    CHECK(r.body->find("terravox_http_replies_total{route=\"/v2/boxes/{level}/{bx}/{by}/"
                       "{bz}\",status=\"200\"} 1\n") != std::string::npos);
}

TEST_CASE("the squares are GeoJSON in the world's coordinates", "[voxelserver][http][router]") {
    RouterFixture f;
    http::Service service{f.world, f.times, f.boxes};
    service.squares = [] {
        http::SquareEntry s;
        s.name = "462_101";
        s.state = "failed";
        s.error = "read /home/ann/secret/462_101.laz: cut \"short\" <b>";
        s.points = 400;
        s.min_x = 10;
        s.max_x = 30;
        s.min_z = -8;
        s.max_z = 2;
        return std::vector{s};
    };
    http::Router router(service);
    const auto json = to_json(router.handle(Request{"GET", "/v2/squares", {}}));
    const auto& square = json["features"].at(0);
    CHECK(square["geometry"]["coordinates"][0][0] == nlohmann::json{10, -2});
    CHECK(square["geometry"]["coordinates"][0][2] == nlohmann::json{30, 8});
    CHECK(square["properties"]["state"] == "failed");
    CHECK(square["properties"]["error"] == "read 462_101.laz: cut \"short\" <b>");
    CHECK(square["properties"]["file"].is_null());
    CHECK(square["properties"]["density_per_m2"] == 400 / (20 * 10 * 0.25));
}

TEST_CASE("what is kept is listed by level", "[voxelserver][http][router]") {
    RouterFixture f;
    (void)f.get("/v2/boxes/0/1/0/0");
    (void)f.get("/v2/boxes/0/0/-1/0");
    CHECK(to_json(f.get("/v2/cached/0"))["memory"] == nlohmann::json{{0, -1, 0}, {1, 0, 0}});
    CHECK(to_json(f.get("/v2/cached/1"))["memory"].empty());
    CHECK(f.get("/v2/cached/3").status == 404);
    CHECK(f.get("/v2/cached/x").status == 400);
}

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

TEST_CASE("each route of the table has a handler", "[voxelserver][http][router]") {
    RouterFixture f;
    for (const http::RouteFacts& route : http::routes()) {
        INFO(route.path);
        Request request{"GET", route.path, {}};
        if (route.methods == http::Methods::kPost) {
            request.method = "POST";
            request.headers = {{"Content-Length", "1"}};
            request.body = "x";
        }
        const Response reply = f.router.handle(request);
        CHECK(reply.bytes().find("nothing there") == std::string_view::npos);
        CHECK((reply.bytes().find("nothing at") == std::string_view::npos) ==
              (route.path.front() == '/'));
    }
}

TEST_CASE("no handler runs for a request that names another edition",
          "[voxelserver][http][router]") {
    RouterFixture f;
    http::Service service{f.world, f.times, f.boxes};
    service.edition = "00112233445566778899aabbccddeeff";
    http::Router router(service);
    const auto status = [&](const std::string& edition) {
        const Request request{"GET", "/v2/boxes/0/0/0/0", {{"terravox-edition", edition}}};
        return router.handle(request).status;
    };
    CHECK(status("ffeeddccbbaa99887766554433221100") == 412);
    CHECK(status("x") == 412);
    CHECK(f.world.requests == 0);
    CHECK(status(service.edition) == 200);
    CHECK(f.world.requests == 1);
    const Response world = router.handle({"GET", "/v2/world", {}});
    CHECK(world.header(http::kEditionHeader) == service.edition);
    // A world without an edition is none that a request could name.
    CHECK(f.get("/healthz", {{"Terravox-Edition", "x"}}).status == 412);
}
