// Rays of one's own: what is seen from the middle of a world, 20 m above the ground, in all
// directions of the compass?
//   rays_of_your_own place.laz
#include <terravox/terravox.hpp>

#include <cmath>
#include <cstdio>
#include <vector>

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: rays_of_your_own WORLD\n");
        return 2;
    }
    try {
        const auto world = terravox::World::open({argv[1]});
        const auto& bounds = world.info().bounds;
        const double east = (bounds.west + bounds.east) / 2;
        const double north = (bounds.south + bounds.north) / 2;

        const std::vector<double> above{east, north, bounds.top + 1};
        const std::vector<double> down{0, 0, -1};
        const double ground = above[2] - world.cast(above, down).distance_m.front();

        constexpr int kRays = 16;
        std::vector<double> origins;
        std::vector<double> directions;
        for (int i = 0; i < kRays; ++i) {
            const double azimuth = 2 * 3.14159265358979 * i / kRays;
            origins.insert(origins.end(), {east, north, ground + 20});
            directions.insert(directions.end(), {std::sin(azimuth), std::cos(azimuth), -0.1});
        }
        const terravox::RayHits hits = world.cast(origins, directions);
        const auto names = terravox::materials();
        for (int i = 0; i < kRays; ++i) {
            const auto n = static_cast<std::size_t>(i);
            std::printf("%5.1f degrees: %s at %.1f m\n", 360.0 * i / kRays,
                        names[hits.material[n]].name.c_str(), hits.distance_m[n]);
        }
        return 0;
    } catch (const terravox::Error& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 1;
    }
}
