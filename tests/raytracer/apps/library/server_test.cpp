#include <terravox/terravox.hpp>

#include <memory>
#include <string>
#include <utility>

#include "tests/catch.hpp"
#include "tests/raytracer/apps/library/own_worlds.hpp"

using namespace terravox;
using terravox::test::Hills;

namespace {

World served_hills() {
    return World::of(std::make_shared<Hills>("EPSG:3794"));
}

OpenOptions without_cache() {
    OpenOptions out;
    out.cache = "none";
    return out;
}

}  // namespace

TEST_CASE("library: a world that is served is the same world elsewhere", "[library]") {
    const World world = served_hills();
    const Server server(world);
    CHECK(server.port() > 0);
    CHECK(server.url() == "http://127.0.0.1:" + std::to_string(server.port()));
    const World there = World::open({server.url()}, without_cache());
    CHECK(there.info().crs == world.info().crs);
    CHECK(there.info().title == world.info().title);
    for (const int level : {0, 1, 3}) {
        const VoxelBlock block = world.block_of(std::nullopt, level);
        CHECK(there.voxels(block).materials == world.voxels(block).materials);
    }
}

TEST_CASE("library: a server keeps its world open", "[library]") {
    auto world = std::make_unique<World>(served_hills());
    const VoxelBlock block = world->block_of(std::nullopt, 2);
    const auto materials = world->voxels(block).materials;
    const Server server(*world);
    world.reset();
    const World there = World::open({server.url()}, without_cache());
    CHECK(there.voxels(block).materials == materials);
}

TEST_CASE("library: nothing is served after the end, and the port is free", "[library]") {
    const World world = served_hills();
    ServerOptions options;
    {
        Server server(world);
        options.port = server.port();
        CHECK_THROWS_AS(Server(world, options), Error);
        server.stop();
        server.stop();
        CHECK_THROWS_AS(World::open({server.url()}, without_cache()), Error);
    }
    const Server again(world, options);
    CHECK(again.port() == options.port);
}

TEST_CASE("library: a server with a token answers nobody without it", "[library]") {
    ServerOptions options;
    options.token = "0123456789abcdef0123456789abcdef";
    const World world = served_hills();
    const Server server(world, options);
    CHECK_THROWS_WITH(World::open({server.url()}, without_cache()), test::contains("token"));
}

TEST_CASE("library: options that make no server are refused", "[library]") {
    const World world = served_hills();
    const auto refused = [&](auto&& change) {
        ServerOptions options;
        change(options);
        CHECK_THROWS_AS(Server(world, options), UsageError);
    };
    refused([](ServerOptions& o) { o.bind = "localhost"; });
    refused([](ServerOptions& o) { o.port = -1; });
    refused([](ServerOptions& o) { o.port = 65536; });
    refused([](ServerOptions& o) { o.token = "short"; });
    refused([](ServerOptions& o) { o.token = "a blank in it"; });
    refused([](ServerOptions& o) { o.token = "a line\r\nmore of it"; });
    refused([](ServerOptions& o) { o.names = {"not a name"}; });
    refused([](ServerOptions& o) { o.memory_mib = 0; });
    refused([](ServerOptions& o) { o.threads = -1; });
}
