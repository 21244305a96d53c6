#include "voxelserver/http/router.hpp"

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

#include "common/voxel/box_codec.hpp"
#include "common/voxel/unreachable_error.hpp"
#include "common/voxel/world_json.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/http/fake_world.hpp"

using namespace terravox;
using http::Header;
using http::Request;
using http::Response;

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

nlohmann::json json_of(const Response& r) {
    return nlohmann::json::parse(r.body ? *r.body : "");
}

}  // namespace

TEST_CASE("a request that names another edition is refused", "[voxelserver][http][router]") {
    test::FakeWorld world;
    util::StageTimes times;
    boxes::BoxCache boxes(world, times, {.ahead = false});
    http::Service service{world, times, boxes};
    service.edition = "00112233445566778899aabbccddeeff";
    http::Router router(service);
    CHECK(router.handle(Request{"GET", "/v2/world", {}}).header("Terravox-Edition") ==
          service.edition);
    struct Case {
        const char* name;
        std::string edition;
        int status;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"none", "", 200},
        {"the same", service.edition, 200},
        {"another", "ffeeddccbbaa99887766554433221100", 412},
        {"no edition at all", "x", 412},
    }));
    DYNAMIC_SECTION(c.name) {
        for (const char* path : {"/v2/boxes/0/0/0/0", "/v2/columns/0/0/0"}) {
            std::vector<Header> headers;
            if (!c.edition.empty())
                headers.push_back({"terravox-edition", c.edition});
            CHECK(router.handle(Request{"GET", path, headers}).status == c.status);
        }
    }
}

TEST_CASE("a far server that does not answer is a bad gateway, and stays unnamed",
          "[voxelserver][http][router]") {
    class Unreachable final : public voxel::ProvenanceWorld {
    public:
        [[nodiscard]] const voxel::WorldInfo& info() const noexcept override {
            return m_fake.info();
        }
        [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey&) override {
            throw voxel::UnreachableError("fetch http://10.0.0.7/v2/boxes: connection refused");
        }
        [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx,
                                                 std::int32_t bz) override {
            return m_fake.column(level, bx, bz);
        }
        [[nodiscard]] voxel::BoxWithInputs box_with_inputs(const voxel::BoxKey& key) override {
            return {box(key), {}};
        }
        [[nodiscard]] voxel::Fingerprint fingerprint(const voxel::InputExtent&) const override {
            return {1, 2};
        }

    private:
        test::FakeWorld m_fake;
    } world;
    util::StageTimes times;
    boxes::BoxCache boxes(world, times, {.ahead = false});
    http::Router router{http::Service{world, times, boxes}};
    const Response reply = router.handle(Request{"GET", "/v2/boxes/0/0/0/0", {}});
    CHECK(reply.status == 502);
    CHECK(reply.header("Retry-After") == "5");
    CHECK(reply.body->find("10.0.0.7") == std::string::npos);
}

TEST_CASE("every path has its status", "[voxelserver][http][router]") {
    struct Case {
        const char* path;
        int status;
    };
    const auto c = GENERATE(values<Case>({
        {"/healthz", 200},
        {"/v2/world", 200},
        {"/v2/stats", 200},
        {"/v2/boxes/0/0/0/0", 200},
        {"/v2/boxes/0/1/-1/-1", 200},
        {"/v2/boxes/2/0/-1/0", 200},
        {"/v2/boxes/0/0/1/0", 204},
        {"/v2/boxes/0/2147483647/-2147483648/0", 204},
        {"/v2/boxes/3/0/0/0", 404},
        {"/v2/boxes/-1/0/0/0", 404},
        {"/v2/boxes/2147483647/0/0/0", 404},
        {"/v2/boxes/0/2147483648/0/0", 400},
        {"/v2/boxes/0/-2147483649/0/0", 400},
        {"/v2/boxes/0/99999999999999999999/0/0", 400},
        {"/v2/boxes/0/x/0/0", 400},
        {"/v2/boxes/0/1x/0/0", 400},
        {"/v2/boxes/0/ 1/0/0", 400},
        {"/v2/boxes/0/+1/0/0", 400},
        {"/v2/boxes/0/-0/0/0", 400},
        {"/v2/boxes/0/007/0/0", 400},
        {"/v2/boxes/0/1.0/0/0", 400},
        {"/v2/boxes/0/1e1/0/0", 400},
        {"/v2/boxes/0/0x1/0/0", 400},
        {"/v2/boxes/0/-/0/0", 400},
        {"/v2/boxes/0//0/0", 400},
        {"/v2/boxes/0/%31/0/0", 400},
        {"/v2/boxes/0/0/0/", 400},
        {"/v2/boxes/0/0/0", 404},
        {"/v2/boxes/0/0/0/0/", 404},
        {"/v2/boxes", 405},
        {"/v2/columns/0/0/0", 200},
        {"/v2/columns/0/99/0", 200},
        {"/v2/columns/3/0/0", 404},
        {"/v2/columns/0/a/0", 400},
        {"/v2/columns/0/0", 404},
        {"/v2/world/", 404},
        {"/V2/world", 404},
        {"//v2/world", 404},
        {"/v2//world", 404},
        {"/v2", 404},
        {"/v1/world", 404},
        {"/../etc/passwd", 404},
        {"/v2/../v2/world", 404},
        {"/%2e%2e/world", 404},
        {"", 404},
        {"*", 404},
        {"v2/world", 404},
        {"/index.html", 404},
    }));
    DYNAMIC_SECTION(c.path) {
        RouterFixture f;
        const Response r = f.get(c.path);
        CHECK(r.status == c.status);
        CHECK_FALSE(r.close);
        if (c.status >= 400) {
            CHECK(r.header("Content-Type") == "application/problem+json");
            CHECK(json_of(r)["status"] == c.status);
        }
    }
}

TEST_CASE("other methods are answered 405 with what is allowed", "[voxelserver][http][router]") {
    const std::string method =
        GENERATE("POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "get");
    RouterFixture f;
    for (const char* path : {"/v2/world", "/v2/boxes/0/0/0/0", "/healthz"}) {
        const Response r = f.send(method, path);
        CHECK(r.status == 405);
        CHECK(r.header("Allow") == "GET, HEAD");
    }
    CHECK(f.send(method, "/nothing").status == 404);
    CHECK(f.world.requests == 0);
}

TEST_CASE("a request with a body is refused and its connection closed",
          "[voxelserver][http][router]") {
    RouterFixture f;
    const Response large = f.get("/v2/world", {{"Content-Length", "1000000000000"}});
    CHECK(large.status == 413);
    CHECK(large.close);
    CHECK(f.get("/v2/world", {{"Content-Length", "1"}, {"Content-Length", "1"}}).status == 400);
    const Response chunked = f.get("/v2/boxes/0/0/0/0", {{"Transfer-Encoding", "chunked"}});
    CHECK(chunked.status == 400);
    CHECK(chunked.close);
    const Response post = f.send("POST", "/v2/world", {{"Content-Length", "2"}});
    CHECK(post.status == 413);
    CHECK(post.close);
    CHECK_FALSE(f.get("/v2/world", {{"Content-Length", "0"}}).close);
    CHECK(f.world.requests == 0);
}

TEST_CASE("HEAD is answered like GET, without the body", "[voxelserver][http][router]") {
    const std::string path = GENERATE("/healthz", "/v2/world", "/v2/boxes/0/0/0/0",
                                      "/v2/boxes/0/0/1/0", "/v2/columns/0/0/0", "/nothing");
    RouterFixture f;
    const Response head = f.send("HEAD", path);
    const Response get = f.get(path);
    CHECK(head.head_only);
    CHECK_FALSE(get.head_only);
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
}

TEST_CASE("air is 204 without body and type", "[voxelserver][http][router]") {
    RouterFixture f;
    const Response r = f.get("/v2/boxes/0/0/1/0");
    CHECK(r.status == 204);
    CHECK_FALSE(r.body);
    CHECK(r.header("Content-Type").empty());
    CHECK(r.header("ETag") == "\"air\"");
}

TEST_CASE("a box that cannot be made is a problem that says why, not air",
          "[voxelserver][http][router]") {
    RouterFixture f;
    f.world.failing.insert({0, 0, 0, 0});
    const Response r = f.get("/v2/boxes/0/0/0/0");
    CHECK(r.status == 500);
    CHECK(r.header("Content-Type") == "application/problem+json");
    CHECK_THAT(json_of(r)["detail"].get<std::string>(),
               test::contains("decode the square 'a\"b': damaged"));
    CHECK(r.header("ETag").empty());
    CHECK(f.get("/v2/boxes/0/1/0/0").status == 200);
    f.world.columns_fail = true;
    CHECK(f.get("/v2/columns/0/0/0").status == 500);
}

TEST_CASE("the world is described as the client reads it", "[voxelserver][http][router]") {
    RouterFixture f;
    const auto info = voxel::world_from_json(*f.get("/v2/world").body, "the reply");
    CHECK(info.title == f.world.info().title);
    CHECK(info.bounds == f.world.info().bounds);
    CHECK(info.levels == f.world.info().levels);
}

TEST_CASE("a column lists its boxes, and heights in voxels of level 0 within the world",
          "[voxelserver][http][router]") {
    RouterFixture f;
    CHECK(json_of(f.get("/v2/columns/0/0/0")) ==
          nlohmann::json{{"by_begin", -1}, {"by_end", 2}, {"min_y", -256}, {"max_y", 512}});
    CHECK(json_of(f.get("/v2/columns/2/0/0")) ==
          nlohmann::json{{"by_begin", -1}, {"by_end", 1}, {"min_y", -256}, {"max_y", 512}});
    CHECK(json_of(f.get("/v2/columns/0/-7/0")) ==
          nlohmann::json{{"by_begin", 0}, {"by_end", 0}, {"min_y", 0}, {"max_y", 0}});
}

TEST_CASE("statistics count requests by route and status", "[voxelserver][http][router]") {
    RouterFixture f;
    (void)f.get("/v2/boxes/0/0/0/0");
    (void)f.get("/v2/boxes/0/0/0/0");
    (void)f.get("/v2/boxes/0/0/1/0");
    (void)f.get("/nothing");
    const auto json = json_of(f.get("/v2/stats"));
    CHECK(json["requests"]["/v2/boxes/{level}/{bx}/{by}/{bz}"]["200"] == 2);
    CHECK(json["requests"]["/v2/boxes/{level}/{bx}/{by}/{bz}"]["204"] == 1);
    CHECK(json["requests"]["unknown"]["404"] == 1);
    CHECK(json["cache"]["hits"] == 1);
    CHECK(json["cache"]["misses"] == 2);
    CHECK(json["stages"].at(0)["name"] == "compression");
}

TEST_CASE("when the queue is full, further boxes are refused with 503 and a time to retry",
          "[voxelserver][http][router]") {
    test::FakeWorld world;
    util::StageTimes times;
    boxes::BoxCache boxes(world, times, {.makers = 1, .queue = 0, .ahead = false});
    http::Router router(http::Service{world, times, boxes});
    world.hold();
    Response first;
    std::thread slow([&] { first = router.handle(Request{"GET", "/v2/boxes/0/0/0/0", {}}); });
    while (world.requests == 0)
        std::this_thread::yield();
    const Response refused = router.handle(Request{"GET", "/v2/boxes/0/1/0/0", {}});
    CHECK(refused.status == 503);
    CHECK(refused.header("Retry-After") == "1");
    CHECK(router.handle(Request{"GET", "/healthz", {}}).status == 200);
    world.release();
    slow.join();
    CHECK(first.status == 200);
    CHECK(router.handle(Request{"GET", "/v2/boxes/0/1/0/0", {}}).status == 200);
}

TEST_CASE("with a token, only open routes answer without it", "[voxelserver][http][router]") {
    RouterFixture f;
    http::Router router(http::Service{f.world, f.times, f.boxes}, "s3cret");
    const auto status = [&](const char* path, std::vector<Header> headers = {}) {
        return router.handle(Request{"GET", path, std::move(headers)}).status;
    };
    CHECK(status("/healthz") == 200);
    for (const char* path : {"/view/", "/view/appearance.bin", "/view/viewer/worker.js"})
        CHECK(status(path) == 200);
    for (const char* path : {"/v2/world", "/v2/boxes/0/0/0/0", "/metrics", "/v2/stats", "/nothing",
                             "/view/place.json", "/view/nothing"}) {
        INFO(path);
        CHECK(status(path) == 401);
    }
    for (const char* wrong :
         {"Bearer s3cre", "Bearer s3crets", "Bearer S3cret", "Bearer ", "Bearer", "Basic s3cret",
          "s3cret", "", "Bearer s3cret, Bearer s3cret"}) {
        INFO(wrong);
        CHECK(status("/v2/world", {{"Authorization", wrong}}) == 401);
    }
    CHECK(status("/v2/world", {{"authorization", "bearer s3cret"}}) == 200);
    CHECK(router.handle(Request{"GET", "/v2/world", {}}).header("WWW-Authenticate") == "Bearer");
    CHECK(f.world.requests == 0);
}

TEST_CASE("a host name that is none of the server's is refused before all else",
          "[voxelserver][http][router]") {
    RouterFixture f;
    http::Router router(http::Service{f.world, f.times, f.boxes}, "",
                        sockets::HttpNames("127.0.0.1", {"voxels.example.org"}));
    for (const http::RouteFacts& route : http::routes()) {
        if (route.path.front() != '/')
            continue;
        INFO(route.path);
        const Response r =
            router.handle(Request{http::is_allowed(route.methods, "GET") ? "GET" : "POST",
                                  route.path,
                                  {{"Host", "attacker.example:8888"}}});
        CHECK(r.status == 421);
        CHECK(r.close);
        CHECK_THAT(json_of(r)["detail"].get<std::string>(),
                   test::contains("attacker.example:8888") && test::contains("--public-name"));
    }
    for (const char* host : {"localhost:8888", "127.0.0.1", "[::1]:8888", "voxels.example.org"})
        CHECK(router.handle(Request{"GET", "/v2/world", {{"Host", host}}}).status == 200);
    CHECK(router.handle(Request{"GET", "/v2/world", {}}).status == 200);  // HTTP/1.0
    CHECK(f.world.requests == 0);
}

TEST_CASE("a page of another origin is refused, and none is invited",
          "[voxelserver][http][router]") {
    RouterFixture f;
    const Header host{"Host", "localhost:8888"};
    CHECK(f.get("/v2/boxes/0/0/0/0", {host,
                                      {"Sec-Fetch-Site", "cross-site"},
                                      {"Sec-Fetch-Mode", "no-cors"},
                                      {"Sec-Fetch-Dest", "image"}})
              .status == 403);
    CHECK(f.get("/v2/world", {host, {"Origin", "http://attacker.example"}}).status == 403);
    CHECK(f.send("POST", "/v2/boxes",
                 {host,
                  {"Origin", "http://attacker.example"},
                  {"Content-Type", "application/json"},
                  {"Content-Length", "14"}})
              .status == 403);
    CHECK(f.send("OPTIONS", "/v2/boxes",
                 {host,
                  {"Origin", "http://attacker.example"},
                  {"Access-Control-Request-Method", "POST"}})
              .status == 403);
    CHECK(f.world.requests == 0);
    CHECK(f.get("/", {host,
                      {"Sec-Fetch-Site", "cross-site"},
                      {"Sec-Fetch-Mode", "navigate"},
                      {"Sec-Fetch-Dest", "document"}})
              .status == 200);
    for (const http::RouteFacts& route : http::routes()) {
        const Response r = f.send(http::is_allowed(route.methods, "GET") ? "GET" : "POST",
                                  route.path, {host, {"Origin", "http://localhost:8888"}});
        CHECK(r.head.find("Access-Control-") == std::string::npos);
    }
}

TEST_CASE("a request with an invalid head is refused before its body is read",
          "[voxelserver][http][router]") {
    RouterFixture f;
    http::Router router(http::Service{f.world, f.times, f.boxes}, "s3cret");
    const Header type{"Content-Type", "application/json"};
    const Header length{"Content-Length", "14"};
    const Header token{"Authorization", "Bearer s3cret"};
    const auto refusal = [&](std::vector<Header> headers) {
        return router.refusal(Request{"POST", "/v2/boxes", std::move(headers)});
    };
    CHECK_FALSE(refusal({type, length, token}));
    struct Case {
        std::vector<Header> headers;
        int status;
    };
    for (const Case& c :
         {Case{{type, length}, 401}, Case{{type, {"Content-Length", "262145"}, token}, 413},
          Case{{type, length, token, {"Host", "attacker.example"}}, 421},
          Case{{type, length, token, {"Origin", "null"}}, 403},
          Case{{type, length, length, token}, 400}}) {
        const auto refused = refusal(c.headers);
        REQUIRE(refused);
        CHECK(refused->status == c.status);
        CHECK(refused->close);
        CHECK_FALSE(refused->head_only);
    }
    const auto head = router.refusal(Request{"HEAD", "/v2/world", {{"Content-Length", "5"}}});
    REQUIRE(head);
    CHECK(head->head_only);
}

TEST_CASE("health is a word for every client, and a reason for those with the token",
          "[voxelserver][http][router]") {
    using State = http::Health::State;
    RouterFixture f;
    http::Health now;
    http::Service service{f.world, f.times, f.boxes};
    service.health = [&] { return now; };
    http::Router open(service), closed(service, "s3cret");
    const auto send = [](http::Router& router, std::vector<Header> headers = {}) {
        return router.handle(Request{"GET", "/healthz", std::move(headers)});
    };
    CHECK(send(open).bytes() == "ok\n");
    now.state = State::kOpening;
    CHECK(send(open).status == 200);
    CHECK(send(closed).bytes() == "opening\n");
    now = {State::kFailed, "read /home/ann/secret place/square.laz: cut short"};
    for (const Response& r :
         {send(open), send(closed), send(closed, {{"Authorization", "Bearer wrong"}}),
          send(open, {{"Authorization", "Bearer s3cret"}})}) {
        CHECK(r.status == 503);
        CHECK(r.header("Retry-After") == "60");
        CHECK(json_of(r)["detail"] ==
              "failed: only kept boxes can be served; the server's log says why");
    }
    CHECK(json_of(send(closed, {{"Authorization", "Bearer s3cret"}}))["detail"] ==
          "failed: read square.laz: cut short");
}

TEST_CASE("no reply names a folder of this machine", "[voxelserver][http][router]") {
    RouterFixture f;
    f.world.fail_with = "read '/home/ann/secret place/square.laz': cut short";
    f.world.failing.insert({0, 0, 0, 0});
    CHECK(json_of(f.get("/v2/boxes/0/0/0/0"))["detail"] == "read 'square.laz': cut short");
    http::Service service{f.world, f.times, f.boxes};
    service.squares = [] {
        http::SquareEntry s;
        s.name = "462_101";
        s.state = "failed";
        s.error = "read /home/ann/secret/462_101.laz: cut short";
        return std::vector{s};
    };
    http::Router router(service);
    CHECK(json_of(router.handle(Request{"GET", "/v2/squares", {}}))["features"].at(
              0)["properties"]["error"] == "read 462_101.laz: cut short");
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
    CHECK(json_of(place)["archive"]["server"] == "../");
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
        s.error = "cut \"short\" <b>";
        s.points = 400;
        s.min_x = 10;
        s.max_x = 30;
        s.min_z = -8;
        s.max_z = 2;
        return std::vector{s};
    };
    http::Router router(service);
    const auto json = json_of(router.handle(Request{"GET", "/v2/squares", {}}));
    const auto& square = json["features"].at(0);
    CHECK(square["geometry"]["coordinates"][0][0] == nlohmann::json{10, -2});
    CHECK(square["geometry"]["coordinates"][0][2] == nlohmann::json{30, 8});
    CHECK(square["properties"]["state"] == "failed");
    CHECK(square["properties"]["file"].is_null());
    CHECK(square["properties"]["density_per_m2"] == 400 / (20 * 10 * 0.25));
}

TEST_CASE("what is kept is listed by level", "[voxelserver][http][router]") {
    RouterFixture f;
    (void)f.get("/v2/boxes/0/1/0/0");
    (void)f.get("/v2/boxes/0/0/-1/0");
    CHECK(json_of(f.get("/v2/cached/0"))["memory"] == nlohmann::json{{0, -1, 0}, {1, 0, 0}});
    CHECK(json_of(f.get("/v2/cached/1"))["memory"].empty());
    CHECK(f.get("/v2/cached/3").status == 404);
    CHECK(f.get("/v2/cached/x").status == 400);
}
