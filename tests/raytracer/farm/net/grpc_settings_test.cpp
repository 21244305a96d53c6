#include "raytracer/farm/net/grpc_settings.hpp"

#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("a peer of gRPC has the name that its socket has", "[raytracer][net][address]") {
    struct Case {
        const char* of_grpc;
        const char* name;
    };
    for (const Case c :
         {Case{"ipv4:192.0.2.7:51234", "192.0.2.7:51234"},
          Case{"ipv6:%5B2001:db8::1%5D:80", "[2001:db8::1]:80"}, Case{"ipv6:[::1]:80", "[::1]:80"},
          Case{"ipv6:%5Bfe80::1%252%5D:80", "[fe80::1]:80"}}) {
        INFO(c.of_grpc);
        CHECK(net::readable_peer(c.of_grpc) == c.name);
    }
}
