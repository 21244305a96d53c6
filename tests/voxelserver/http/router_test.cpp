#include "voxelserver/http/router.hpp"

#include <nlohmann/json.hpp>
#include <thread>

#include "common/voxel/box_codec.hpp"
#include "common/voxel/world_json.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/http/fake_world.hpp"

using namespace terravox;
using http::Header;
using http::Request;
using http::Response;

namespace {

struct Fixture {
    test::FakeWorld world;
    util::StageTimes times;
    http::Router router{world, times, {}};

    Response get(std::string_view path, std::vector<Header> headers = {}) { return router.handle(Request{"GET", path, std::move(headers)}); }
    Response ask(std::string_view method, std::string_view path, std::vector<Header> headers = {}) {
        return router.handle(Request{method, path, std::move(headers)});
    }
};

nlohmann::json json_of(const Response& r) { return nlohmann::json::parse(r.body ? *r.body : ""); }

}  // namespace

TEST_CASE("every path has its status", "[voxelserver][http][router]") {
    struct Case {
        const char* path;
        int status;
    };
    const auto c = GENERATE(values<Case>({
        {"/", 200}, {"/healthz", 200}, {"/v2/world", 200}, {"/v2/stats", 200},
        {"/v2/boxes/0/0/0/0", 200}, {"/v2/boxes/0/1/-1/-1", 200}, {"/v2/boxes/2/0/-1/0", 200},
        {"/v2/boxes/0/0/1/0", 204}, {"/v2/boxes/0/2147483647/-2147483648/0", 204},
        {"/v2/boxes/3/0/0/0", 404}, {"/v2/boxes/-1/0/0/0", 404}, {"/v2/boxes/2147483647/0/0/0", 404},
        {"/v2/boxes/0/2147483648/0/0", 400}, {"/v2/boxes/0/-2147483649/0/0", 400}, {"/v2/boxes/0/99999999999999999999/0/0", 400},
        {"/v2/boxes/0/x/0/0", 400}, {"/v2/boxes/0/1x/0/0", 400}, {"/v2/boxes/0/ 1/0/0", 400}, {"/v2/boxes/0/+1/0/0", 400},
        {"/v2/boxes/0/-0/0/0", 400}, {"/v2/boxes/0/007/0/0", 400}, {"/v2/boxes/0/1.0/0/0", 400}, {"/v2/boxes/0/1e1/0/0", 400},
        {"/v2/boxes/0/0x1/0/0", 400}, {"/v2/boxes/0/-/0/0", 400}, {"/v2/boxes/0//0/0", 400}, {"/v2/boxes/0/%31/0/0", 400},
        {"/v2/boxes/0/0/0/", 400}, {"/v2/boxes/0/0/0", 404}, {"/v2/boxes/0/0/0/0/", 404}, {"/v2/boxes", 404},
        {"/v2/columns/0/0/0", 200}, {"/v2/columns/0/99/0", 200}, {"/v2/columns/3/0/0", 404}, {"/v2/columns/0/a/0", 400}, {"/v2/columns/0/0", 404},
        {"/v2/world/", 404}, {"/V2/world", 404}, {"//v2/world", 404}, {"/v2//world", 404}, {"/v2", 404}, {"/v1/world", 404},
        {"/../etc/passwd", 404}, {"/v2/../v2/world", 404}, {"/%2e%2e/world", 404}, {"", 404}, {"*", 404}, {"v2/world", 404}, {"/index.html", 404},
    }));
    DYNAMIC_SECTION(c.path) {
        Fixture f;
        const Response r = f.get(c.path);
        CHECK(r.status == c.status);
        CHECK_FALSE(r.close);
        if (c.status >= 400) {
            CHECK(*r.header("Content-Type") == "application/problem+json");
            CHECK(json_of(r)["status"] == c.status);
        }
    }
}

TEST_CASE("other methods are answered 405 with what is allowed", "[voxelserver][http][router]") {
    const std::string method = GENERATE("POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "get");
    Fixture f;
    for (const char* path : {"/", "/v2/world", "/v2/boxes/0/0/0/0", "/healthz"}) {
        const Response r = f.ask(method, path);
        CHECK(r.status == 405);
        REQUIRE(r.header("Allow"));
        CHECK(*r.header("Allow") == "GET, HEAD");
    }
    CHECK(f.ask(method, "/nothing").status == 404);
    CHECK(f.world.asked == 0);
}

TEST_CASE("a request with a body is refused and its connection closed", "[voxelserver][http][router]") {
    Fixture f;
    const Response large = f.get("/v2/world", {{"Content-Length", "1000000000000"}});
    CHECK(large.status == 413);
    CHECK(large.close);
    const Response chunked = f.get("/v2/boxes/0/0/0/0", {{"Transfer-Encoding", "chunked"}});
    CHECK(chunked.status == 400);
    CHECK(chunked.close);
    const Response post = f.ask("POST", "/v2/world", {{"Content-Length", "2"}});
    CHECK(post.status == 405);
    CHECK(post.close);
    CHECK_FALSE(f.get("/v2/world", {{"Content-Length", "0"}}).close);
    CHECK(f.world.asked == 0);
}

TEST_CASE("HEAD is answered like GET, without the body", "[voxelserver][http][router]") {
    const std::string path = GENERATE("/", "/healthz", "/v2/world", "/v2/boxes/0/0/0/0", "/v2/boxes/0/0/1/0", "/v2/columns/0/0/0", "/nothing");
    Fixture f;
    const Response head = f.ask("HEAD", path), get = f.get(path);
    CHECK(head.head_only);
    CHECK_FALSE(get.head_only);
    CHECK(head.status == get.status);
    CHECK(head.content_length() == get.content_length());
    CHECK((head.header("ETag") ? *head.header("ETag") : "") == (get.header("ETag") ? *get.header("ETag") : ""));
}

TEST_CASE("an entity tag that is still right is answered 304 without a body", "[voxelserver][http][router]") {
    const std::string path = GENERATE("/v2/world", "/v2/boxes/0/0/0/0", "/v2/boxes/0/0/1/0", "/v2/boxes/0/1000/0/0");
    Fixture f;
    const Response first = f.get(path);
    REQUIRE(first.header("ETag"));
    const std::string etag = *first.header("ETag");
    const Response again = f.get(path, {{"if-none-match", "\"other\", " + etag}});
    CHECK(again.status == 304);
    CHECK_FALSE(again.body);
    CHECK(*again.header("ETag") == etag);
    CHECK(f.get(path, {{"If-None-Match", "\"other\""}}).status == first.status);
}

TEST_CASE("a box is sent as a zstd frame under its media type", "[voxelserver][http][router]") {
    Fixture f;
    const Response r = f.get("/v2/boxes/0/1/-1/-1");
    CHECK(*r.header("Content-Type") == voxel::kBoxMediaType);
    const auto box = voxel::decompress_box(std::as_bytes(std::span(*r.body)), "the reply");
    CHECK(box->key() == voxel::BoxKey{0, 1, -1, -1});
}

TEST_CASE("air is 204 without body and type", "[voxelserver][http][router]") {
    Fixture f;
    const Response r = f.get("/v2/boxes/0/0/1/0");
    CHECK(r.status == 204);
    CHECK_FALSE(r.body);
    CHECK_FALSE(r.header("Content-Type"));
    CHECK(r.header("ETag"));
}

TEST_CASE("a box that cannot be made is a problem that says why, not air", "[voxelserver][http][router]") {
    Fixture f;
    f.world.failing.insert({0, 0, 0, 0});
    const Response r = f.get("/v2/boxes/0/0/0/0");
    CHECK(r.status == 500);
    CHECK(*r.header("Content-Type") == "application/problem+json");
    CHECK_THAT(json_of(r)["detail"].get<std::string>(), test::contains("decode the square 'a\"b': damaged"));
    CHECK_FALSE(r.header("ETag"));
    CHECK(f.get("/v2/boxes/0/1/0/0").status == 200);
    f.world.columns_fail = true;
    CHECK(f.get("/v2/columns/0/0/0").status == 500);
}

TEST_CASE("the world is described as the client reads it", "[voxelserver][http][router]") {
    Fixture f;
    const auto info = voxel::world_from_json(*f.get("/v2/world").body, "the reply");
    CHECK(info.title == f.world.info().title);
    CHECK(info.bounds == f.world.info().bounds);
    CHECK(info.levels == f.world.info().levels);
}

TEST_CASE("a column tells its boxes, and heights in voxels of level 0 within the world", "[voxelserver][http][router]") {
    Fixture f;
    CHECK(json_of(f.get("/v2/columns/0/0/0")) == nlohmann::json{{"by_begin", -1}, {"by_end", 2}, {"min_y", -256}, {"max_y", 512}});
    CHECK(json_of(f.get("/v2/columns/2/0/0")) == nlohmann::json{{"by_begin", -1}, {"by_end", 1}, {"min_y", -256}, {"max_y", 512}});
    CHECK(json_of(f.get("/v2/columns/0/-7/0")) == nlohmann::json{{"by_begin", 0}, {"by_end", 0}, {"min_y", 0}, {"max_y", 0}});
}

TEST_CASE("statistics count requests by route and status", "[voxelserver][http][router]") {
    Fixture f;
    (void)f.get("/v2/boxes/0/0/0/0");
    (void)f.get("/v2/boxes/0/0/0/0");
    (void)f.get("/v2/boxes/0/0/1/0");
    (void)f.get("/nothing");
    const auto json = json_of(f.get("/v2/stats"));
    CHECK(json["requests"]["/v2/boxes"]["200"] == 2);
    CHECK(json["requests"]["/v2/boxes"]["204"] == 1);
    CHECK(json["requests"]["unknown"]["404"] == 1);
    CHECK(json["cache"]["hits"] == 1);
    CHECK(json["cache"]["misses"] == 2);
    CHECK(json["stages"].at(0)["name"] == "compression");
}

TEST_CASE("when the line is full, further boxes are refused with 503 and a time to ask again", "[voxelserver][http][router]") {
    test::FakeWorld world;
    util::StageTimes times;
    http::Router router(world, times, {.makers = 1, .queue = 0});
    world.hold();
    Response first;
    std::thread slow([&] { first = router.handle(Request{"GET", "/v2/boxes/0/0/0/0", {}}); });
    while (world.asked == 0) std::this_thread::yield();
    const Response refused = router.handle(Request{"GET", "/v2/boxes/0/1/0/0", {}});
    CHECK(refused.status == 503);
    REQUIRE(refused.header("Retry-After"));
    CHECK(router.handle(Request{"GET", "/healthz", {}}).status == 200);
    world.release();
    slow.join();
    CHECK(first.status == 200);
    CHECK(router.handle(Request{"GET", "/v2/boxes/0/1/0/0", {}}).status == 200);
}
