#include "voxelserver/serve/http/route_answers.hpp"

#include <nlohmann/json.hpp>

#include "tests/catch.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"

using namespace terravox;
using http::Health;
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
