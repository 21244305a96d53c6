#include "voxelserver/serve/http/route_answers.hpp"

#include <nlohmann/json.hpp>

#include "common/voxel/world.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"

using namespace terravox;
using http::Request;
using http::Response;

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
    json.erase("map");
    CHECK(json == nlohmann::json::parse(voxel::world_to_json(world.info())));
}

TEST_CASE("a client that has the description gets 304, until the world is another",
          "[voxelserver][http][world]") {
    const test::FakeWorld world;
    const http::WorldRoute route(world.info(), "");
    const std::string etag = route.answer(Request{"GET", "/v2/world", {}}).header("ETag");
    const Request again{"GET", "/v2/world", {{"If-None-Match", etag}}};
    const Response same = route.answer(again);
    CHECK(same.status == 304);
    CHECK_FALSE(same.body);
    voxel::WorldInfo other = world.info();
    other.title = "another";
    CHECK(http::WorldRoute(other, "").answer(again).status == 200);
}
