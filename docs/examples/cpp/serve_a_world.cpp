// Serves a world over HTTP: open the address in a browser for a map and a view in three dimensions,
// or render it from elsewhere with `terravox render ADDRESS`. Ends when its input does.
//   serve_a_world place.laz
#include <terravox/terravox.hpp>

#include <cstdio>

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: serve_a_world WORLD\n");
        return 2;
    }
    try {
        const auto world = terravox::World::open({argv[1]});
        terravox::Server server(world);
        std::printf("%s\n", server.url().c_str());
        std::fflush(stdout);
        while (std::getchar() != EOF) {
        }
        return 0;
    } catch (const terravox::Error& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 1;
    }
}
