#include "raytracer/trace/tile_pixels.hpp"

#include <set>
#include <utility>

#include "raytracer/trace/tracer_tools.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::Job;
using terravox::test::small_scene;

namespace {

struct Named {
    const char* name;
    tiles::RenderTile tile;
};

const Named kTiles[] = {
    {"whole", {0, 0, 0, 0, 16, 16}},
    {"odd corner and size", {1, 0, 5, 3, 18, 10}},
    {"coarse", {2, 0, 3, 3, 40, 33, 4}},
    {"refining", {3, 1, 0, 0, 21, 21, 2, true}},
    {"no pixel of its step", {4, 0, 1, 1, 2, 2, 4}},
};

}  // namespace

TEST_CASE("the parts of a tile have each of its pixels once, in its place", "[raytracer][trace]") {
    Job job(small_scene());
    trace::TracerTools tools(job.view, job.blocks, std::size_t{1} << 20);
    trace::TilePixels pixels;
    for (const std::size_t max_blocks : {std::size_t{1}, std::size_t{3}, std::size_t{1000}})
        for (const auto& [name, tile] : kTiles) {
            CAPTURE(name, max_blocks);
            std::vector<std::pair<int, int>> wanted;
            tile.each_pixel([&](int x, int y) { wanted.emplace_back(x, y); });
            pixels.start(tile);
            CHECK(pixels.cut(job.view.camera, tools.beams) == wanted.size());
            std::set<std::uint32_t> places;
            while (!pixels.is_last_part()) {
                pixels.next_part(max_blocks);
                for (const trace::TilePixel& pixel : pixels.pixels()) {
                    REQUIRE(pixel.place < wanted.size());
                    CHECK(std::pair(pixel.x, pixel.y) == wanted[pixel.place]);
                    CHECK(places.insert(pixel.place).second);
                }
            }
            CHECK(places.size() == wanted.size());
            CHECK(pixels.tile() == tile);
        }
}
