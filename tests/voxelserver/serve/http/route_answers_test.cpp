#include "voxelserver/serve/http/route_answers.hpp"

#include <functional>
#include <new>
#include <nlohmann/json.hpp>

#include "common/util/error.hpp"
#include "common/voxel/world.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"
#include "voxelserver/serve/boxes/admission_control.hpp"
#include "voxelserver/serve/http/service.hpp"

using namespace terravox;
using http::Health;
using http::Request;
using http::Response;

TEST_CASE("health says what the server can do, and why not to clients with the token",
          "[voxelserver][http][state]") {
    struct Case {
        const char* name;
        Health health;
        bool has_token;
        int status;
        const char* text;  ///< the body, or the detail of the problem
    };
    const auto c = GENERATE(values<Case>({
        {"open", {}, false, 200, "ok\n"},
        {"opening", {Health::State::kOpening}, false, 200, "opening\n"},
        {"failed, without the token",
         {Health::State::kFailed, "read /home/ann/a.laz: cut short"},
         false,
         503,
         "failed: only kept boxes can be served; the server's log says why"},
        {"failed, to a client with the token",
         {Health::State::kFailed, "read /home/ann/a.laz: cut short"},
         true,
         503,
         "failed: read a.laz: cut short"},
    }));
    DYNAMIC_SECTION(c.name) {
        test::FakeWorld world;
        util::StageTimes times;
        boxes::BoxCache boxes(world, times, {.ahead = false});
        http::Service service{world, times, boxes};
        service.health = [&] { return c.health; };
        const http::Request request{"GET", "/healthz", {}};
        const http::PathParts parts = http::match_route(request.path).parts;
        const Response reply = http::answer_health(service, {request, parts, c.has_token});
        CHECK(reply.status == c.status);
        REQUIRE(reply.body);
        CHECK(reply.header("Retry-After") == (c.status == 503 ? "60" : ""));
        if (c.status == 200)
            CHECK(*reply.body == c.text);
        else
            CHECK(nlohmann::json::parse(*reply.body)["detail"] == c.text);
    }
}

TEST_CASE("the reply about the world is the format's text with the map's zooms",
          "[voxelserver][http][world]") {
    const test::FakeWorld world;
    const http::WorldRoute route(world.info(), "");
    const Response reply = route.answer(Request{"GET", "/v2/world", {}});
    CHECK(reply.status == 200);
    CHECK(reply.header("Content-Type") == "application/json");
    REQUIRE(reply.body);
    CHECK(voxel::world_from_json(*reply.body, "the reply").title == world.info().title);
    auto json = nlohmann::json::parse(*reply.body);
    CHECK(json["map"]["zooms"] == nlohmann::json{0, world.info().levels - 1});
    voxel::WorldInfo other = world.info();
    other.title = "another";
    CHECK(http::WorldRoute(other, "").answer(Request{"GET", "/v2/world", {}}).header("ETag") !=
          reply.header("ETag"));
    json.erase("map");
    CHECK(json == nlohmann::json::parse(voxel::world_to_json(world.info())));
}

namespace {

Response reply_to(const std::function<void()>& failing) {
    try {
        failing();
    } catch (...) {
        return http::reply_to_current_exception({"GET", "/v2/boxes/0/0/0/0", {}});
    }
    return {};
}

}  // namespace

TEST_CASE("each exception has its reply, and its line in the log", "[voxelserver][http][error]") {
    struct Case {
        const char* name;
        std::function<void()> failing;
        int status;
        const char* detail;
        const char* retry_after;
        const char* log;  ///< "" = no line
    };
    const auto c = GENERATE(values<Case>({
        {"too many at work", [] { throw boxes::OverloadedError("make a box: too many"); }, 503,
         "make a box: too many", "1", ""},
        {"another server is silent",
         [] { throw voxel::UnreachableError("fetch http://10.0.0.7: refused"); }, 502,
         "the server that this world comes from does not answer, or refuses; the log says why", "5",
         "GET /v2/boxes/0/0/0/0: fetch http://10.0.0.7: refused\n"},
        {"no memory", [] { throw std::bad_alloc(); }, 500, "out of memory", "",
         "GET /v2/boxes/0/0/0/0: out of memory\n"},
        {"a damaged file", [] { throw util::Error("read /home/ann/a.laz: cut short"); }, 500,
         "read a.laz: cut short", "", "GET /v2/boxes/0/0/0/0: read /home/ann/a.laz: cut short\n"},
        {"something else", [] { throw 7; }, 500, "unknown error", "",
         "GET /v2/boxes/0/0/0/0: unknown error\n"},
    }));
    DYNAMIC_SECTION(c.name) {
        const test::Warnings log;
        const Response reply = reply_to(c.failing);
        CHECK(reply.status == c.status);
        CHECK(reply.header("Content-Type") == "application/problem+json");
        CHECK(reply.header("Retry-After") == c.retry_after);
        REQUIRE(reply.body);
        CHECK(nlohmann::json::parse(*reply.body)["detail"] == c.detail);
        CHECK(log.text() == c.log);
    }
}
