#include "tests/catch.hpp"
#include "tests/raytracer/farm_bench.hpp"
#include "tests/voxelserver/make/worlds/remote/served_boxes.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

/// A voxel server with the metadata of the job's world, and without boxes.
BadServer make_server(const Job& job) {
    return BadServer(
        [json = voxel::world_to_json(job.world->info())](const std::string& path, int) {
            return path == "/v2/world" ? Deed{.body = json} : problem(404);
        });
}

}  // namespace

TEST_CASE(
    "a worker requests nothing from a server that it may not use, whatever a coordinator names",
    "[raytracer][farm][worker]") {
    struct Case {
        const char *name, *user, *rest;
        bool is_allowed = false;
    };
    const auto c = GENERATE(values<Case>({
        {"a voxel server on the worker's own machine", "", ""},
        {"a path of another service", "", "/admin"},
        {"a query takes the path that is appended", "", "/admin?x="},
        {"a fragment takes it", "", "/admin#"},
        {"a user", "root:secret@", ""},
        {"a box archive", "", "/place.tvx"},
        {"a path of an allowed origin that would take what is appended", "", "/admin?x=", true},
        {"a fragment of one", "", "/admin#", true},
        {"an archive of one", "", "/place.tvx?x=.tvx", true},
    }));
    DYNAMIC_SECTION(c.name) {
        Job job(farm_scene());
        BadServer server = make_server(job);
        const std::string url = "http://" + std::string(c.user) + server.url().substr(7) + c.rest;
        remote::HttpAccess http = remote::no_http_access();
        if (c.is_allowed)
            http.limits->private_origins.push_back(remote::HttpOrigin::parse(server.url()));
        FarmBench bench(job, std::nullopt, 200, {url, ""});
        bench.add_worker(1, http);
        output::Film film = empty_film(job);
        CHECK(bench.render(film).missing == 0);
        CHECK(server.heads().empty());
    }
}

TEST_CASE(
    "a worker uses the servers that its own configuration allows, with the token of that one, and "
    "the coordinator for the rest",
    "[raytracer][farm][worker]") {
    Job wanted(farm_scene());
    const std::string picture = to_bytes(render_scene(wanted, 1));
    struct Case {
        const char* name;
        bool allowed, in_private, with_token;
    };
    const auto c = GENERATE(values<Case>({
        {"no origin is allowed", false, false, false},
        {"the origin is allowed, but not on this machine", true, false, false},
        {"it is allowed on this machine, too", true, true, false},
        {"it has a token", true, true, true},
    }));
    DYNAMIC_SECTION(c.name) {
        Job job(farm_scene());
        BadServer server = make_server(job);
        const remote::HttpOrigin origin = remote::HttpOrigin::parse(server.url());
        remote::HttpAccess http = remote::no_http_access();
        if (c.allowed)
            (c.in_private ? http.limits->private_origins : http.limits->origins).push_back(origin);
        if (c.with_token)
            http.token.emplace(origin, "a-token-of-a-server");
        FarmBench bench(job, std::nullopt, 200, {server.url(), ""});
        bench.add_worker(1, http);
        output::Film film = empty_film(job);
        CHECK(bench.render(film).missing == 0);
        CHECK((to_bytes(film) == picture));
        const auto heads = server.heads();
        CHECK(heads.empty() == !c.in_private);
        for (const std::string& head : heads)
            CHECK((head.find("Authorization: Bearer a-token-of-a-server\r\n") !=
                   std::string::npos) == c.with_token);
    }
}
