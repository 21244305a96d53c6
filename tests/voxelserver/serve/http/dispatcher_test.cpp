#include "voxelserver/serve/http/router.hpp"

#include "tests/catch.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"

using namespace terravox;
using http::Header;
using http::Request;
using http::Response;
using http::Route;

namespace {

struct DispatcherFixture {
    test::FakeWorld world;
    util::StageTimes times;
    boxes::BoxCache boxes{world, times, {.ahead = false}};
    http::RequestCounts counts;
    http::Service service{world, times, boxes};

    Response run(std::string_view path, std::vector<Header> headers = {}) {
        http::Dispatcher dispatcher(service, counts);
        const http::RouteMatch match = http::match_route(path);
        const Request request{"GET", path, std::move(headers)};
        return dispatcher.run(match.facts.route, {request, match.parts});
    }
};

}  // namespace

TEST_CASE("each route of the table has a handler", "[voxelserver][http][dispatcher]") {
    DispatcherFixture f;
    for (const http::RouteFacts& route : http::routes()) {
        INFO(route.path);
        const Response reply = f.run(route.path);
        const bool is_path = route.path.front() == '/';
        CHECK((reply.bytes().find("nothing there") == std::string_view::npos) == is_path);
    }
}

TEST_CASE("no handler runs for a request that names another edition",
          "[voxelserver][http][dispatcher]") {
    DispatcherFixture f;
    f.service.edition = "00112233445566778899aabbccddeeff";
    const auto status = [&](const std::string& edition) {
        return f.run("/v2/boxes/0/0/0/0", {{"terravox-edition", edition}}).status;
    };
    CHECK(status("ffeeddccbbaa99887766554433221100") == 412);
    CHECK(status("x") == 412);
    CHECK(f.world.requests == 0);
    CHECK(status(f.service.edition) == 200);
    CHECK(f.world.requests == 1);
    CHECK(f.run("/v2/world").header(http::kEditionHeader) == f.service.edition);
}

TEST_CASE("a world without an edition refuses each request that names one",
          "[voxelserver][http][dispatcher]") {
    DispatcherFixture f;
    CHECK(f.run("/healthz").status == 200);
    CHECK(f.run("/healthz", {{"Terravox-Edition", "x"}}).status == 412);
}
