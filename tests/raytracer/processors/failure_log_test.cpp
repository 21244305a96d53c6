#include "raytracer/processors/failure_log.hpp"

#include "tests/catch.hpp"
#include "tests/raytracer/processors/pool_parts.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

tiles::RenderTile rows(std::uint32_t tile, int begin, int end) {
    tiles::RenderTile out = tile_of_rows(tile, end);
    out.y0 = begin;
    return out;
}

}  // namespace

TEST_CASE("a member that fails again and again counts once", "[raytracer][sched]") {
    processors::FailureLog log;
    CHECK(log.add(rows(0, 0, 8), "a") == 1);
    CHECK(log.add(rows(0, 0, 8), "a") == 1);
    CHECK(log.add(rows(0, 0, 16), "a") == 1);
    CHECK(log.add(rows(0, 0, 8), "b") == 2);
    CHECK(log.add(rows(0, 0, 8), "c") == 3);
}

TEST_CASE("failures count where bands share a row of the same tile", "[raytracer][sched]") {
    struct Case {
        const char* name;
        tiles::RenderTile band;
        std::size_t members;
    };
    const auto c = GENERATE(values<Case>({
        {"a part of it", rows(3, 20, 24), 2},
        {"more than it", rows(3, 0, 64), 2},
        {"its last row", rows(3, 31, 40), 2},
        {"rows before it", rows(3, 0, 16), 1},
        {"rows after it", rows(3, 32, 40), 1},
        {"another tile", rows(4, 16, 32), 1},
    }));
    DYNAMIC_SECTION(c.name) {
        processors::FailureLog log;
        log.add(rows(3, 16, 32), "a");
        CHECK(log.add(c.band, "b") == c.members);
    }
}
